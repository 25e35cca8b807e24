#!/usr/bin/env python3
"""Gmsh's own hexahedra: the share of the volume of those with a scaled Jacobian above 0.2.

    python3 benches/solvers/gmsh_hexes.py SOLID.off=LENGTH…

LENGTH is that of the edges, relative to the longest side of the solid's box. Needs numpy and gmsh (4.15.2 measured).
"""
import math, sys, tempfile
from pathlib import Path
import gmsh
import numpy as np
from laplace import read_off, write_stl

CORNERS = [(0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7), (4, 7, 5, 0), (5, 4, 6, 1), (6, 5, 7, 2), (7, 6, 4, 3)]
TETS = [(0, 1, 3, 4), (1, 2, 3, 6), (1, 6, 3, 4), (1, 5, 6, 4), (3, 6, 7, 4)]


def volumes(places, tets):
    a, b, c, d = (places[:, [tet[k] for tet in tets]] for k in range(4))
    return (np.cross(b - a, c - a) * (d - a)).sum(axis=2).sum(axis=1) / 6


def scaled_jacobians(places):
    least = np.full(len(places), np.inf)
    for here, *ends in CORNERS:
        ways = [places[:, end] - places[:, here] for end in ends]
        a, b, c = (way / np.linalg.norm(way, axis=1, keepdims=True) for way in ways)
        least = np.minimum(least, (np.cross(a, b) * c).sum(axis=1))
    return least


def main():
    print("| solid | hexahedra | share of the volume | scaled Jacobian: least | at 5 % | other elements |\n|---|---|---|---|---|---|")
    for word in sys.argv[1:]:
        path, _, length = word.partition("=")
        vertices, triangles = read_off(path)
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        volume = abs((a * np.cross(b, c)).sum() / 6)
        size = float(length) * (vertices.max(axis=0) - vertices.min(axis=0)).max()
        gmsh.initialize(interruptible=False)
        for option, value in [("Algorithm", 6), ("Algorithm3D", 9), ("Recombine3DAll", 1), ("Recombine3DLevel", 2),
                              ("MeshSizeMin", size), ("MeshSizeMax", size)]:
            gmsh.option.setNumber("Mesh." + option, value)
        gmsh.option.setNumber("General.Terminal", 0)
        with tempfile.TemporaryDirectory() as folder:
            write_stl(folder + "/s.stl", vertices, triangles)
            gmsh.merge(folder + "/s.stl")
        gmsh.model.mesh.classifySurfaces(math.radians(40), True, True, math.radians(180))
        gmsh.model.mesh.createGeometry()
        gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop([tag for _, tag in gmsh.model.getEntities(2)])])
        gmsh.model.geo.synchronize()
        gmsh.model.mesh.generate(3)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        place = np.zeros((int(tags.max()) + 1, 3))
        place[tags.astype(int)] = coordinates.reshape(-1, 3)
        kinds, elements, corners = gmsh.model.mesh.getElements(3)
        gmsh.finalize()
        others = sum(len(found) for kind, found in zip(kinds, elements) if kind != 5)
        hexes = [found.reshape(-1, 8).astype(int) for kind, found in zip(kinds, corners) if kind == 5]
        if not hexes:
            print(f"| {Path(path).stem}, {length} | 0 | 0 | | | {others} |", flush=True)
            continue
        places = place[hexes[0]]
        quality = scaled_jacobians(places)
        share = np.abs(volumes(places, TETS))[quality > 0.2].sum() / volume
        print(f"| {Path(path).stem}, {length} | {len(places)} | {share:.3f} | {quality.min():.2f} | {np.quantile(quality, .05):.2f} | {others} |",
              flush=True)


if __name__ == "__main__":
    sys.exit(main())
