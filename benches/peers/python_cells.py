"""Cells with neighbors and areas of the same random sites: chebloyd beside pyvoro2, multivoro, freud and SciPy.

    python benches/peers/python_cells.py [COUNT…]

Each case runs in a process of its own; a package that is not there is left out. Seconds are those of the call
and of reading its neighbors and areas out into arrays (wall, and CPU of all threads), memory is what the process
grew by at its peak, lines are those of the user's code below.
"""

import inspect
import json
import os
import resource
import subprocess
import sys
import time

import numpy as np

LIMIT = 900  # seconds a case may take


def chebloyd_(points):
    import chebloyd

    cells = chebloyd.cells(points)
    return cells.neighbors, cells.areas


def chebloyd_without_shapes(points):
    import chebloyd

    cells = chebloyd.cells(points, shapes=False)
    return cells.neighbors, cells.areas


def pyvoro2_(points):
    import pyvoro2

    box = pyvoro2.Box(((0, 1), (0, 1), (0, 1)))
    cells = pyvoro2.compute(points, domain=box, output="cells")
    pyvoro2.annotate_face_properties(cells, box)
    neighbors = np.array([face["adjacent_cell"] for cell in cells for face in cell["faces"]])
    areas = np.array([face["area"] for cell in cells for face in cell["faces"]])
    return neighbors, areas


def multivoro_(points):
    import multivoro

    alike = np.ones(len(points))
    cells = multivoro.compute_voronoi(points, limits=[[0, 0, 0], [1, 1, 1]], radii=alike, n_threads=2)
    neighbors = np.concatenate([cell.get_neighbors() for cell in cells])
    areas = []
    for cell in cells:
        vertices, flat = cell.get_vertices(), cell.get_face_vertices()
        place = 0
        while place < len(flat):
            face = vertices[flat[place + 1 : place + 1 + flat[place]]]
            place += 1 + flat[place]
            arms = face[1:] - face[0]
            areas.append(np.linalg.norm(np.cross(arms[:-1], arms[1:]).sum(0)) / 2)
    return neighbors, np.array(areas)


def freud_(points):
    import freud

    # Periodic only: walls are not there.
    voronoi = freud.locality.Voronoi().compute((freud.box.Box.cube(1), points - 0.5))
    return voronoi.nlist.point_indices, voronoi.nlist.weights


def scipy_(points):
    from scipy.spatial import Voronoi

    # Without walls: sites mirrored at the cube's sides bound the cells.
    mirrored = [points]
    for axis in range(3):
        for side in (0, 1):
            image = points.copy()
            image[:, axis] = 2 * side - image[:, axis]
            mirrored.append(image[np.abs(image[:, axis] - side) < 4 / len(points) ** (1 / 3)])
    voronoi = Voronoi(np.concatenate(mirrored))
    # Each facet between two cells is there once.
    inner = (voronoi.ridge_points < len(points)).any(1)
    areas = np.empty(inner.sum())
    for number, ridge in enumerate(np.flatnonzero(inner)):
        corners = voronoi.vertices[voronoi.ridge_vertices[ridge]]
        arms = corners[1:] - corners[0]
        areas[number] = np.linalg.norm(np.cross(arms[:-1], arms[1:]).sum(0)) / 2
    return voronoi.ridge_points[inner], areas


CASES = {
    "chebloyd": chebloyd_,
    "chebloyd, shapes=False": chebloyd_without_shapes,
    "chebloyd without AVX2": chebloyd_,
    "pyvoro2": pyvoro2_,
    "multivoro": multivoro_,
    "freud": freud_,
    "SciPy": scipy_,
}


def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def run(name, count):
    """One case in this process: seconds, CPU seconds, MB, facets, their total area."""
    points = np.random.default_rng(1).random((count, 3))
    try:
        CASES[name](points[:100])
    except ImportError as missing:
        return {"missing": str(missing)}
    before, wall, cpu = peak(), time.perf_counter(), time.process_time()
    neighbors, areas = CASES[name](points)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return {"wall": wall, "cpu": cpu, "MB": peak() - before, "facets": len(areas), "area": float(np.sum(areas))}


def main(counts):
    """Prints the table."""
    print(f"{'':24}{'sites':>9}{'seconds':>10}{'CPU s':>9}{'MB':>8}{'lines':>7}  facets, area")
    for count in counts:
        for name, case in CASES.items():
            lines = sum(
                1
                for line in inspect.getsource(case).splitlines()[1:]
                if line.strip() and not line.strip().startswith(("#", "return"))
            )
            try:
                done = subprocess.run(
                    [sys.executable, __file__, "--case", name, str(count)],
                    capture_output=True,
                    text=True,
                    timeout=LIMIT,
                    env=os.environ | ({"CHEBLOYD_CPU": "baseline"} if "without AVX2" in name else {}),
                )
                found = json.loads(done.stdout) if done.returncode == 0 else {"missing": done.stderr.strip()[-60:]}
            except subprocess.TimeoutExpired:
                found = {"missing": f"not done in {LIMIT} s"}
            if "missing" in found:
                print(f"{name:24}{count:9}  {found['missing']}", flush=True)
                continue
            numbers = f"{found['wall']:10.2f}{found['cpu']:9.2f}{found['MB']:8.0f}{lines:7}"
            print(f"{name:24}{count:9}{numbers}  {found['facets']}, {found['area']:.6g}", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--case"]:
        print(json.dumps(run(sys.argv[2], int(sys.argv[3]))))
    else:
        main([int(count) for count in sys.argv[1:]] or [10_000, 100_000, 1_000_000])
