#!/usr/bin/env python3
"""Races chebloyd against other Voronoi libraries on the same sites, one thread each.

    benches/peers/race.py [--rounds 3] [--count 100000] [--large]

Programs take turns within a round, and the least time over the rounds counts: what others do on the
machine can only add to it. See README.md.
"""

import argparse
import importlib.util
import os
import pathlib
import shutil
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WORK = ROOT / "target" / "peers"

# Lloyd iterations that make relaxed sites.
MOVES = 100

# SciPy needs half a minute for a run.
SCIPY_ROUNDS = 1

# The builds of chebloyd that race, with options of the compiler: as the repository builds it, for
# processors with AVX2, and for any x86-64.
BUILDS = {"AVX2": None, "any": ""}

# What is read of a row of `chebloyd bench`.
COLUMNS = ["cells", "iteration", "global"]


def call(*command, **options):
    """Runs a command and returns what it prints."""
    options = {"check": True, "text": True, "stdout": subprocess.PIPE, "cwd": ROOT} | options
    return subprocess.run([str(word) for word in command], **options).stdout


def build_chebloyd():
    """Builds chebloyd in every way and returns the programs: name to path."""
    programs = {}
    for name, flags in BUILDS.items():
        target = ROOT / "target" if flags is None else WORK / name
        environment = os.environ | ({} if flags is None else {"RUSTFLAGS": flags})
        command = ["cargo", "build", "--release", "--bin", "chebloyd", "--target-dir", target]
        call(*command, env=environment)
        programs[name] = target / "release" / "chebloyd"
    return programs


def build_peers():
    """Builds what can be built of the others and returns the programs: name to command."""
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


def sites(kind, count, program):
    """The file of so many sites of a kind, made once."""
    file = WORK / f"{kind}-{count}.csv"
    if not file.exists():
        options = ["--sites", kind, "--count", count, "--moves", MOVES, "--save", file]
        call(program, "bench", *options)
    return file


def chebloyd(program, file):
    """Column to CPU microseconds per site; without those that do not apply."""
    options = ["--points", file, "--threads", 1, "--repeat", 1, "--cpu"]
    stages = ["--stages", ",".join(COLUMNS)]
    head, row = call(program, "bench", *options, *stages).splitlines()[:2]
    # The columns' names follow three words, their values the name and the number of the sites.
    cells = dict(zip(head.split()[3:], row.split()[2:]))
    return {name: float(cells[name]) for name in COLUMNS if cells[name] != "-"}


def race(file, builds, peers, rounds):
    """Program, or build and column, to its least time in CPU microseconds per site."""
    times = {}
    for turn in range(rounds):
        for build, program in builds.items():
            for column, time in chebloyd(program, file).items():
                times.setdefault((build, column), []).append(time)
        for name, command in peers.items():
            if name != "SciPy" or turn < SCIPY_ROUNDS:
                answer = call(*command, file).split()
                assert abs(float(answer[1]) - 1) < 1e-6, f"{name}: the volumes sum to {answer[1]}"
                times.setdefault(name, []).append(float(answer[0]))
    return {name: min(values) for name, values in times.items()}


def print_head(peers):
    """Prints the columns' names."""
    words = [f"{'':<16} {'chebloyd':<8}"]
    words += [f"{column:>9}" for column in COLUMNS]
    words += [f"{peer:>9} {'':<18}" for peer in peers]
    print(*words)


def print_rows(name, times, peers):
    """Prints a row per build of chebloyd: its times, and those of the others with ratios to them."""
    for build in BUILDS:
        own = [times.get((build, column)) for column in COLUMNS]
        words = [f"{name:<16} {build:<8}"]
        words += [f"{'-' if time is None else f'{time:.2f}':>9}" for time in own]
        for peer in peers:
            ratios = ", ".join(f"{time / times[peer]:.2f}" for time in own[1:] if time)
            words += [f"{times[peer]:>9.2f} {f'({ratios})':<18}"]
        print(*words, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--count", type=int, default=100_000, help="how many sites")
    parser.add_argument("--large", action="store_true", help="10^6 random sites against Voro++, too")
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    builds, programs = build_chebloyd(), build_peers()
    print("CPU µs per site, one thread; in brackets, relative to it, chebloyd's columns but the first")
    print_head(programs)
    counts = [options.count, 1_000_000] if options.large else [options.count]
    for count in counts:
        # A million relaxed sites take ten minutes to make.
        for kind in ["random", "relaxed", "lattice"] if count < 1e6 else ["random"]:
            peers = {name: programs[name] for name in programs if count < 1e6 or name == "Voro++"}
            file = sites(kind, count, builds["AVX2"])
            times = race(file, builds, peers, options.rounds)
            print_rows(f"{kind} {count}", times, peers)


if __name__ == "__main__":
    main()
