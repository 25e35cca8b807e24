#!/usr/bin/env python3
"""Races chebloyd against other Voronoi libraries on the same sites, one thread each.

    benches/peers/race.py [--rounds 3] [--large]

Programs take turns within a round, and the median over the rounds counts, so that a busy machine
slows all of them. See README.md.
"""

import argparse
import importlib.util
import os
import pathlib
import shutil
import statistics
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WORK = ROOT / "target" / "peers"

# Lloyd iterations that make relaxed sites.
MOVES = 100

# SciPy needs half a minute for a run.
SCIPY_ROUNDS = 1


def call(*command, **options):
    """Runs a command and returns what it prints."""
    options = {"check": True, "text": True, "stdout": subprocess.PIPE, "cwd": ROOT} | options
    return subprocess.run([str(word) for word in command], **options).stdout


def build():
    """Builds what can be built and returns the programs: name to command."""
    call("cargo", "build", "--release", "--bin", "chebloyd")
    programs = {}
    if shutil.which("g++"):
        flags = ["-O3", "-march=native", "-I/usr/include/voro++"]
        driver = WORK / "voropp"
        call("g++", *flags, HERE / "voropp.cpp", "-o", driver, "-lvoro++")
        programs["Voro++"] = [driver]
    package, target = HERE / "meshless" / "Cargo.toml", WORK / "meshless"
    call("cargo", "build", "--release", "--manifest-path", package, "--target-dir", target)
    programs["meshless"] = [target / "release" / "meshless-peer"]
    if importlib.util.find_spec("scipy"):
        programs["SciPy"] = [os.sys.executable, HERE / "scipy_mirrored.py"]
    return programs


def sites(kind, count):
    """The file of so many sites of a kind, made once."""
    file = WORK / f"{kind}-{count}.csv"
    if not file.exists():
        options = ["--sites", kind, "--count", count, "--moves", MOVES, "--save", file]
        call(ROOT / "target/release/chebloyd", "bench", *options)
    return file


def chebloyd(file):
    """CPU microseconds per site for cells, and for a whole iteration with the minimizers."""
    options = ["--points", file, "--threads", 1, "--repeat", 1, "--cpu"]
    row = call(ROOT / "target/release/chebloyd", "bench", *options).splitlines()[1].split()
    return float(row[4]), float(row[7])


def race(file, programs, rounds):
    """Program to its median, in CPU microseconds per site."""
    times = {}
    for turn in range(rounds):
        cells, iteration = chebloyd(file)
        times.setdefault("cells", []).append(cells)
        times.setdefault("iteration", []).append(iteration)
        for name, command in programs.items():
            if name != "SciPy" or turn < SCIPY_ROUNDS:
                answer = call(*command, file).split()
                assert abs(float(answer[1]) - 1) < 1e-6, f"{name}: the volumes sum to {answer[1]}"
                times.setdefault(name, []).append(float(answer[0]))
    return {name: statistics.median(values) for name, values in times.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--large", action="store_true", help="10^6 sites against Voro++, too")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    programs = build()
    print("CPU µs per site, one thread; in brackets, chebloyd's iteration relative to it")
    print(f"{'':<16} {'cells':>7} {'iteration':>10}", *(f"{name:>16}" for name in programs))
    counts = [100_000, 1_000_000] if options.large else [100_000]
    for count in counts:
        for kind in ["random", "relaxed", "lattice"]:
            few = {name: programs[name] for name in programs if count < 1e6 or name == "Voro++"}
            times = race(sites(kind, count), few, options.rounds)
            row = f"{kind} {count}"
            print(f"{row:<16} {times['cells']:>7.2f} {times['iteration']:>10.2f}", end=" ")
            for name in few:
                ratio = times["iteration"] / times[name]
                print(f"{times[name]:>9.2f} ({ratio:.2f})", end=" ")
            print(flush=True)


if __name__ == "__main__":
    main()
