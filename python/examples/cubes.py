"""Relaxes random sites, draws energy and movement with pandas and the cells with PyVista, writes a mesh.

    python python/examples/cubes.py [FOLDER]
"""

import sys
from pathlib import Path

import chebloyd
import numpy as np

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "cubes")
folder.mkdir(parents=True, exist_ok=True)

sites = np.random.default_rng(1).random((216, 3))
result = chebloyd.relax(sites, method="quasi_newton", iterations=100)
before, after = (chebloyd.measure(points) for points in (sites, result.sites))
print(f"energy {before.energy_percent:.2f} % → {after.energy_percent:.2f} %")
print(f"cubeness {before.cubeness:.3f} → {after.cubeness:.3f}")

frame = result.frame()
frame.to_csv(folder / "log.csv", index=False)
try:
    axes = frame.plot(x="iteration", y="energy_percent", legend=False, ylabel="energy in percent of cubes")
    axes.figure.savefig(folder / "energy.png", dpi=120)
except ImportError as missing:
    print(f"SKIPPED: the curve ({missing})")

cells = chebloyd.cells(result.sites)
print(f"{len(cells)} cells, Σ volume {cells.volumes.sum():.15f}, {np.diff(cells.facet_offsets).mean():.2f} facets each")
try:
    import pyvista

    grid = cells.to_pyvista().explode(0.15)
    plotter = pyvista.Plotter(off_screen=True, window_size=(900, 800))
    plotter.add_mesh(grid, scalars="volume", show_edges=True, cmap="viridis")
    plotter.screenshot(folder / "cells.png")
except ImportError as missing:
    print(f"SKIPPED: the picture ({missing})")

# The same as the program's run with all its files, and its cells as one mesh for OpenFOAM.
scene = {"sites": {"list": sites.tolist()}, "method": {"quasi_newton": {"iterations": 100}}}
chebloyd.scene(scene, out=folder / "run", force=True)
mesh = chebloyd.mesh(folder / "run", folder / "mesh", force=True)
print(f"mesh: {mesh.cells} cells, {mesh.faces} faces, non-orthogonality at most {mesh.non_orthogonality_max:.1f}°")
