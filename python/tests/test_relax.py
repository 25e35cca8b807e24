"""Relaxations, figures and energies: bits of the command line, callbacks, signals, sentences."""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import chebloyd
import numpy as np
import pytest
from chebloyd import Box

RNG = np.random.default_rng(0)
SITES = RNG.random((1000, 3))
PROGRAM = [sys.executable, "-m", "chebloyd"]


def run(*arguments, env=None):
    return subprocess.run([*PROGRAM, *map(str, arguments)], check=True, capture_output=True, text=True, env=env)


def test_relaxing_lowers_the_energy_and_keeps_the_input():
    before = SITES.copy()
    result = chebloyd.relax(SITES, iterations=20)
    assert (SITES == before).all() and result.sites.shape == (1000, 3) and result.sites.dtype == np.float64
    assert len(result.log) == 21 and result.ended == "iterations" and result.notes == []
    assert result.log[-1]["energy_percent"] < 103.6 < result.log[0]["energy_percent"]
    frame = result.frame()
    assert list(frame["iteration"]) == list(range(21)) and frame["energy_percent"].is_monotonic_decreasing


@pytest.mark.parametrize(
    "options",
    [
        {"iterations": 5},
        {"iterations": 5, "method": "quasi_newton"},
        {"iterations": 6, "method": chebloyd.Anneal(rounds=2, first_steps=2, steps=2), "order": 2},
        {"iterations": 3, "cells": "linf"},
    ],
)
def test_the_bits_are_those_of_the_command_line_and_of_any_threads(tmp_path, options):
    sites = SITES[:200]
    domain = Box(periodic=(True, False, True))
    ours = chebloyd.relax(sites, domain=domain, threads=1, **options)
    again = chebloyd.relax(sites, domain=domain, threads=3, **options)
    assert ours.sites.tobytes() == again.sites.tobytes()
    method = options.get("method", "lloyd")
    method = {method: {}} if isinstance(method, str) else method.key()
    for keys in method.values():
        keys["iterations"] = options["iterations"]
    scene = {"sites": {"list": sites.tolist()}, "method": method, "domain": {"box": {"periodic": [True, False, True]}}}
    scene |= {name: options[name] for name in ("order", "cells") if name in options}
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    run("relax", tmp_path / "scene.json", "--out", tmp_path / "run", "--quiet")
    theirs = np.loadtxt(tmp_path / "run/sites.csv", delimiter=",", skiprows=1)
    assert (theirs == ours.sites).all()
    log = [json.loads(line) for line in (tmp_path / "run/log.jsonl").read_text().splitlines()]
    for one, other in zip(log, ours.log, strict=True):
        assert {**one, "seconds": 0} == {**other, "seconds": 0}
    # A scene's dict and file are the same run, in memory and with files.
    assert chebloyd.scene(scene).sites.tobytes() == ours.sites.tobytes()
    assert chebloyd.scene(tmp_path / "scene.json").sites.tobytes() == ours.sites.tobytes()
    described = chebloyd.scene(scene, out=tmp_path / "again")
    assert described.ended == "iterations" and (tmp_path / "again/cells.vtu").exists()
    assert (tmp_path / "again/sites.csv").read_bytes() == (tmp_path / "run/sites.csv").read_bytes()
    ours.save(tmp_path / "saved")
    assert (tmp_path / "saved/sites.csv").read_bytes() == (tmp_path / "run/sites.csv").read_bytes()


def test_the_plane_relaxes_too():
    sites = RNG.random((100, 2))
    result = chebloyd.relax(sites, iterations=10)
    assert result.sites.shape == (100, 2) and result.log[-1]["energy_percent"] < result.log[0]["energy_percent"]
    square = chebloyd.relax(sites * 0.4, domain=chebloyd.Polygon([[0, 0], [0.4, 0], [0.4, 0.4], [0, 0.4]]), iterations=2)
    assert square.sites.max() <= 0.4


def test_callbacks_see_every_record_stop_and_raise():
    seen = []
    result = chebloyd.relax(SITES, callback=lambda record, sites: seen.append((record, sites)) or len(seen) < 4)
    assert result.ended == "callback" and [record["iteration"] for record, _ in seen] == [0, 1, 2, 3]
    assert (seen[0][1] == SITES).all() and (seen[3][1] == result.sites).all()
    with pytest.raises(ZeroDivisionError):
        chebloyd.relax(SITES, callback=lambda record, sites: 1 / 0)


def test_lists_strides_and_orders_are_the_same_numbers():
    ours = chebloyd.relax(SITES, iterations=1).sites
    for same in (SITES.tolist(), np.asfortranarray(SITES), np.repeat(SITES, 2, axis=0)[::2]):
        assert chebloyd.relax(same, iterations=1).sites.tobytes() == ours.tobytes()


def test_what_is_wrong_is_told_in_the_programs_sentences(tmp_path):
    refused = [
        ("lies outside the domain", lambda: chebloyd.relax(SITES + 1)),
        ("did you mean `iterations`", lambda: chebloyd.relax(SITES, iteration=3)),
        (r"\(n, 3\) is needed", lambda: chebloyd.relax(SITES[:, :1])),
        ("sites 0 and 1000 are at the same place", lambda: chebloyd.relax(np.vstack((SITES, SITES[:1])))),
        ("is not finite", lambda: chebloyd.relax([[0.5, 0.5, np.nan]])),
        ("0 sites have no cells", lambda: chebloyd.relax(np.empty((0, 3)))),
        ("no volume", lambda: chebloyd.relax(SITES, domain=Box((0, 0, 0), (1, 0, 1)))),
        ("did you mean `lloyd`", lambda: chebloyd.relax(SITES, method="loyd")),
        ("triclinic", lambda: chebloyd.relax(SITES, domain=np.eye(3))),
        ("chooses the method", lambda: chebloyd.relax(SITES, goal="cubes", method="lloyd")),
        ("a domain is a Box", lambda: chebloyd.relax(SITES, domain="cube")),
        ("unexpected argument '--densty'", lambda: chebloyd.mass("none.stl", densty=1)),
    ]
    for sentence, call in refused:
        with pytest.raises(ValueError, match=sentence):
            call()
    with pytest.raises(FileNotFoundError, match="none.stl"):
        chebloyd.mass(tmp_path / "none.stl")
    with pytest.raises(FileNotFoundError, match="none.json"):
        chebloyd.scene(tmp_path / "none.json")
    with pytest.raises(ValueError, match="holds a run|already"):
        for _ in range(2):
            chebloyd.scene({"sites": {"random": {"count": 5}}, "method": {"lloyd": {"iterations": 1}}}, out=tmp_path / "run")


def test_figures_and_energies_agree_with_each_other_and_with_differences():
    sites = SITES[:60]
    for domain in (Box(), Box(periodic=True), chebloyd.HalfSpaces(np.vstack((np.c_[-np.eye(3), np.zeros(3)], [1, 1, 1, 3])))):
        figures = chebloyd.measure(sites, domain=domain)
        cells = figures["cells"]
        assert abs(cells["volume"].sum() / figures.domain_volume - 1) < 1e-12
        assert cells["gradient"].shape == cells["center"].shape == (60, 3) and (cells["center_energy"] <= cells["energy"]).all()
        value, gradient = chebloyd.energy(sites, domain=domain)
        assert abs(value - cells["energy"].sum()) < 1e-12
        step = np.zeros_like(sites)
        step[7] = RNG.normal(size=3) * 1e-6
        ends = [chebloyd.energy(sites + sign * step, domain=domain)[0] for sign in (-1, 1)]
        assert abs((ends[1] - ends[0]) / 2 - (gradient * step).sum()) < 1e-5 * abs((gradient * step).sum()) + 1e-15
    per_cell = json.loads(run("measure", "--count", 20, "--per-cell").stdout)
    scene = chebloyd.scene({"sites": {"random": {"count": 20}}, "method": {"lloyd": {"iterations": 0}}})
    ours = chebloyd.measure(scene.sites)
    assert per_cell["energy_percent"] == ours.energy_percent
    assert [cell["energy"] for cell in per_cell["cells"]] == ours["cells"]["energy"].tolist()


def test_the_lock_is_free():
    ticks, stop = [], threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.002)

    thread = threading.Thread(target=tick)
    thread.start()
    began = time.perf_counter()
    chebloyd.relax(RNG.random((5000, 3)), iterations=3)
    took = time.perf_counter() - began
    stop.set()
    thread.join()
    assert len(ticks) > took / 0.05


INTERRUPTED = """
import chebloyd, numpy, os, signal, threading, time
# A process in the background may have been told to ignore it.
signal.signal(signal.SIGINT, signal.default_int_handler)
rng = numpy.random.default_rng(1)
sites = rng.random(({count}, 3))
print("go", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("raised", flush=True)
    # The threads of the call are idle when this process takes no more time.
    deadline = time.perf_counter() + 60
    spent, idle = time.process_time(), 0
    began = time.perf_counter()
    while idle < 3 and time.perf_counter() < deadline:
        time.sleep(0.05)
        now = time.process_time()
        idle = idle + 1 if now - spent < 0.01 else 0
        spent = now
    print("idle", time.perf_counter() - began - 0.15, flush=True)
"""


def interrupted(call, count, after):
    """Seconds from the signal to KeyboardInterrupt, and from there until all threads are idle."""
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED.format(call=call, count=count)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "go\n"
    time.sleep(after)
    began = time.perf_counter()
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "raised\n"
    raised = time.perf_counter() - began
    word, idle = process.stdout.readline().split()
    assert word == "idle" and process.wait() == 0
    return raised, float(idle)


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize(
    "call",
    ["chebloyd.relax(sites, iterations=10**6)", "chebloyd.cells(sites, threads=1)", "chebloyd.measure(sites, threads=1)"],
)
def test_ctrl_c_raises_and_the_threads_stop(call):
    # Times of a loaded machine are no test: only that both come long before the work would be done.
    raised, idle = interrupted(call, 300_000, 0.3)
    print(f"\n{call}: raised after {raised:.3f} s, idle after {idle:.3f} s more")
    assert raised < 10 and idle < 30


def test_forked_processes_compute():
    chebloyd.relax(SITES, iterations=1)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map(moves, [1, 2]) == [2, 3]


def moves(count):
    return len(chebloyd.relax(SITES, iterations=count).log)


HASHES = """
import hashlib, chebloyd, numpy
sites = numpy.random.default_rng(5).random((300, 3))
relaxed = chebloyd.relax(sites, iterations=3, method="quasi_newton").sites
cells = chebloyd.cells(sites, domain=chebloyd.Box(periodic=True))
print(chebloyd.CPU, hashlib.sha256(relaxed.tobytes() + cells.vertices.tobytes() + cells.areas.tobytes()).hexdigest())
"""


def test_both_native_halves_have_the_same_bits():
    def forced(cpu):
        env = os.environ | {"CHEBLOYD_CPU": cpu}
        done = subprocess.run([sys.executable, "-c", HASHES], capture_output=True, text=True, env=env)
        return done.stdout.split(), done.stderr

    (cpu, bits), _ = forced("baseline")
    from chebloyd._baseline import _chebloyd as baseline

    is_whole = any(Path(chebloyd.__file__).parent.glob("_v3/_chebloyd*"))
    assert cpu == ("v3" if baseline.is_v3() else "baseline") and not (is_whole and baseline.is_v3())
    if baseline.has_v3() and is_whole:
        assert forced("v3") == (["v3", bits], "") and forced("auto") == (["v3", bits], "")
    assert "it can be auto, baseline or v3" in forced("avx")[1]


def test_importing_takes_less_than_a_fifth_of_a_second_and_every_name_is_there():
    code = "import time; t = time.process_time(); import chebloyd; print(time.process_time() - t)"
    times = [float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout) for _ in range(3)]
    assert min(times) < 0.2
    assert {*chebloyd.__all__, "print"} <= {*dir(chebloyd)}
    assert all(hasattr(chebloyd, name) for name in dir(chebloyd)) and not hasattr(chebloyd, "voronoi")
