"""The program's commands under their own names: the objects that --json prints."""

import json
import subprocess
import sys
from pathlib import Path

import chebloyd
import numpy as np
import pytest

SCENES = Path(__file__).parents[2] / "scenes"
CASES = Path(__file__).parents[2] / "tests/cases"


def printed(*arguments):
    done = subprocess.run([sys.executable, "-m", "chebloyd", *map(str, arguments), "--json"], capture_output=True, text=True)
    return json.loads(done.stdout)


def test_solids_are_weighed_integrated_stood_and_spun():
    bracket = SCENES / "bracket.off"
    assert chebloyd.mass(bracket, density="1 + x") == printed("mass", bracket, "--density=1 + x")
    with pytest.raises(OSError, match="no-such.json"):
        chebloyd.mass(bracket, density="@no-such.json")
    assert chebloyd.integrate(bracket, monomials=1)["volume"]["0,0,0"] == pytest.approx(chebloyd.mass(bracket).volume)
    standing = chebloyd.stand(bracket, range=(0.5, 2))
    theirs = printed("stand", bracket, "--range=0.5,2")
    assert {**standing, "seconds": 0} == {**theirs, "seconds": 0} and standing.feasible in (True, False)
    spun = chebloyd.spin(bracket, axis=(0, 0, 0, 0, 0, 1), range=(0.5, 2), basis="cells:50")
    assert spun.feasible in (True, False) and len(spun["center_of_mass"]) == 3
    infeasible = chebloyd.stand(bracket, target=(1e3, 1e3, None), range=(0.9, 1.1))
    assert not infeasible.feasible and infeasible.failure


def test_runs_become_meshes_pages_curves_and_pictures(tmp_path):
    scene = {"sites": {"random": {"count": 40}}, "method": {"lloyd": {"iterations": 3}}}
    run = chebloyd.scene(scene, out=tmp_path / "run")
    assert run.ended == "iterations" and run["final"]["sites"] == 40
    mesh = chebloyd.mesh(tmp_path / "run", tmp_path / "mesh")
    assert mesh.cells == 40 and abs(mesh.volume - 1) < 1e-12 and (tmp_path / "mesh/constant/polyMesh/points").exists()
    again = chebloyd.mesh(check=tmp_path / "mesh", limit={"nonorth": 1})
    assert again.cells == 40 and "nonorth" in again.failure
    chebloyd.report(tmp_path / "run", output=tmp_path / "report.html")
    log = chebloyd.relax(np.random.default_rng(0).random((30, 3)), iterations=2).log
    chebloyd.plot(tmp_path / "run/log.jsonl", log, output=tmp_path / "curves.svg")
    chebloyd.fragments(scene, tmp_path / "fragments.png", site=3)
    for file in ("report.html", "curves.svg", "fragments.png"):
        assert (tmp_path / file).stat().st_size > 1000
    with pytest.raises(ValueError, match="--force"):
        chebloyd.plot(log, output=tmp_path / "curves.svg")
    before = (tmp_path / "curves.svg").read_bytes()
    chebloyd.plot(log, output=tmp_path / "curves.svg", force=True)
    assert (tmp_path / "curves.svg").read_bytes() != before  # one log, not two


def test_prints_are_weighed_and_rewritten(tmp_path):
    bar = CASES / "gcode/bar-prusaslicer.gcode"
    assert chebloyd.mass(bar) == printed("mass", bar)
    out = tmp_path / "out.gcode"
    written = chebloyd.print(bar, out, density="0.5 + 0.01*(x - 50)")
    assert written.written and written.infill["obtained"]["volume"] == pytest.approx(3777.4, abs=1e-3)
    assert chebloyd.mass(out).center_of_mass[0] > chebloyd.mass(bar).center_of_mass[0]
    with pytest.raises(ValueError, match="--force"):
        chebloyd.print(bar, out, density=1)


def test_schemas_and_other_commands():
    assert "sites" in chebloyd.schema()["properties"]
    assert "relax" in chebloyd.command("completions", "bash")["text"]
    octree = chebloyd.octree(SCENES / "bracket.off", depths="2-3")
    assert octree
    table = chebloyd.bench(count=100, stages="index", repeat=1)["text"]
    assert "index" in table
    assert subprocess.run([sys.executable, "-m", "chebloyd", "--version"], capture_output=True).returncode == 0
    assert subprocess.run([sys.executable, "-m", "chebloyd", "mass"], capture_output=True).returncode == 2
