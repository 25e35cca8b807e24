"""Mass, center and inertia of tetrahedra of linear density in vectorized NumPy.

The formulas of Bukenberger & Lensch eq. 1-4, with the inertia tensor from the same Dirichlet
weights, as one would write them with whole-array operations. Prints nanoseconds per tetrahedron:
the least of five runs on one core, data in memory, corners already gathered.
"""

import os
import sys
import time

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np


def mass_properties(corners, densities):
    """corners: n x 4 x 3, densities: n x 4."""
    a, b, c, d = (corners[:, k] for k in range(4))
    volumes = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6
    total = densities.sum(axis=1)
    masses = volumes * total / 4
    corner_sum = corners.sum(axis=1)
    weighed = np.einsum("ik,ikj->ij", densities, corners)
    mass = masses.sum()
    first = (volumes[:, None] * (total[:, None] * corner_sum + weighed)).sum(axis=0) / 20
    half = 0.5 * total[:, None] * corner_sum + weighed
    outer = np.einsum("ij,ik->ijk", half, corner_sum)
    squares = np.einsum("ik,ikl,ikm->ilm", total[:, None] + 2 * densities, corners, corners)
    second = np.einsum("i,ijk->jk", volumes, squares + outer + outer.transpose(0, 2, 1)) / 120
    center = first / mass
    inertia = np.trace(second) * np.eye(3) - second
    inertia -= mass * (center @ center * np.eye(3) - np.outer(center, center))
    return mass, center, inertia


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    generator = np.random.default_rng(1)
    corners = generator.random((count, 4, 3))
    densities = 1 + corners[:, :, 2]
    best = float("inf")
    for _ in range(5):
        start = time.perf_counter()
        mass_properties(corners, densities)
        best = min(best, time.perf_counter() - start)
    print(best / count * 1e9)


main()
