"""SciPy: cells with volumes and centroids of the sites in a file, in the unit cube.

SciPy (Qhull) knows no walls: sites near a wall are mirrored in it, which makes the wall a facet.
Prints CPU microseconds per site and the sum of the volumes.
"""

import sys
import time

import numpy as np
from scipy.spatial import ConvexHull, Voronoi

# Sites within so many mean spacings of a wall are mirrored in it: cells reach two or so.
REACH = 5.0

sites = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1)
began = time.process_time()
reach = REACH / len(sites) ** (1 / 3)
points = [sites]
for axis in range(3):
    for wall in (0.0, 1.0):
        image = sites[abs(sites[:, axis] - wall) < reach].copy()
        image[:, axis] = 2 * wall - image[:, axis]
        points.append(image)
diagram = Voronoi(np.concatenate(points))
volumes, centroids = np.zeros(len(sites)), np.zeros((len(sites), 3))
for site in range(len(sites)):
    corners = diagram.vertices[diagram.regions[diagram.point_region[site]]]
    # Corners of exact lattices coincide and are coplanar; Qhull is told to live with that.
    hull = ConvexHull(corners, qhull_options="Qt")
    triangles = corners[hull.simplices] - sites[site]
    sixfold = abs(np.linalg.det(triangles))
    volumes[site] = sixfold.sum() / 6
    centroids[site] = sites[site] + (sixfold[:, None] * triangles.sum(axis=1)).sum(axis=0) / (
        4 * sixfold.sum()
    )
seconds = time.process_time() - began
print(f"{1e6 * seconds / len(sites):.3f} {volumes.sum():.15g} {centroids.sum():g}")
