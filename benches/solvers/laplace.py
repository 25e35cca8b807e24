#!/usr/bin/env python3
"""Errors of one Laplace problem on near-cubic cells, Gmsh's tetrahedra and polyDualMesh's polyhedra.

    python3 benches/solvers/laplace.py [--sizes 10,20] [--solids bracket,torus] [--work DIR] [--chebloyd PROGRAM]

README.md beside this file says what is needed and what was measured. Every mesh is a case of OpenFOAM below DIR,
kept and used again.
"""
import argparse, json, math, os, re, shutil, subprocess, sys
from pathlib import Path
import numpy as np

HERE = Path(__file__).resolve().parent
SCENES = HERE.parent.parent / "scenes"
ROOT8 = math.sqrt(8.0)


def exact(p):
    """cos 2x cos 2y cosh(√8 z) / cosh √8: harmonic."""
    return np.cos(2 * p[:, 0]) * np.cos(2 * p[:, 1]) * np.cosh(ROOT8 * p[:, 2]) / math.cosh(ROOT8)


def exact_gradient(p):
    x, y, z = p.T
    c = 1.0 / math.cosh(ROOT8)
    return c * np.stack([
        -2 * np.sin(2 * x) * np.cos(2 * y) * np.cosh(ROOT8 * z),
        -2 * np.cos(2 * x) * np.sin(2 * y) * np.cosh(ROOT8 * z),
        ROOT8 * np.cos(2 * x) * np.cos(2 * y) * np.sinh(ROOT8 * z)], axis=1)


def call(*words, cwd=None):
    env = dict(os.environ)
    env.setdefault("WM_PROJECT_DIR", "/usr/share/openfoam")  # Debian's programs ask for it
    done = subprocess.run([str(word) for word in words], cwd=cwd, env=env, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, words))} ended with {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


# --- meshes as OpenFOAM has them ---

def entries(path):
    text = Path(path).read_text()
    return re.sub(r"^.*?FoamFile\s*\{.*?\}", "", text, count=1, flags=re.S)


def numbers(path, width):
    text = entries(path)
    body = text[text.index("(") + 1:text.rindex(")")]
    return np.array(re.sub(r"[()]", " ", body).split(), float).reshape(-1, width)


class Mesh:
    """Centers, areas and volumes by the definitions of OpenFOAM."""

    def __init__(self, case):
        folder = Path(case) / "constant/polyMesh"
        points = numbers(folder / "points", 3)
        text = entries(folder / "faces")
        loops = re.findall(r"\d+\s*\(([\d\s]+)\)", text[text.index("(") + 1:])  # long ones stand on several lines
        faces = [np.array(loop.split(), int) for loop in loops]
        owner = numbers(folder / "owner", 1).astype(int).ravel()
        neighbor = numbers(folder / "neighbour", 1).astype(int).ravel()
        self.inner, self.cells = len(neighbor), int(owner.max()) + 1
        self.centers, self.areas = np.empty((len(faces), 3)), np.empty((len(faces), 3))
        for size in {len(face) for face in faces}:
            which = np.array([n for n, face in enumerate(faces) if len(face) == size])
            corners = points[np.stack([faces[n] for n in which])]
            following = np.roll(corners, -1, axis=1)
            middle = corners.mean(axis=1, keepdims=True)
            parts = np.cross(following - corners, middle - corners)
            if size == 3:
                self.centers[which], self.areas[which] = middle[:, 0], 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
                continue
            weights = np.linalg.norm(parts, axis=2, keepdims=True)
            thirds = corners + following + middle
            self.centers[which] = (weights * thirds).sum(axis=1) / (3 * weights.sum(axis=1) + 1e-300)
            self.areas[which] = 0.5 * parts.sum(axis=1)
        sides = [(owner, self.centers, self.areas), (neighbor, self.centers[:self.inner], -self.areas[:self.inner])]
        middle, count = np.zeros((self.cells, 3)), np.zeros(self.cells)
        for cell, center, _ in sides:
            np.add.at(middle, cell, center)
            np.add.at(count, cell, 1)
        middle /= count[:, None]
        thrice, weighted = np.zeros(self.cells), np.zeros((self.cells, 3))
        for cell, center, area in sides:
            pyramid = ((center - middle[cell]) * area).sum(axis=1)
            np.add.at(thrice, cell, pyramid)
            np.add.at(weighted, cell, pyramid[:, None] * (0.75 * center + 0.25 * middle[cell]))
        self.volumes, self.centroids = thrice / 3, weighted / thrice[:, None]
        text = entries(folder / "boundary")
        self.patches = [(name, int(count), int(start)) for name, count, start in
                        re.findall(r"(\w+)\s*\{[^}]*?nFaces\s+(\d+);[^}]*?startFace\s+(\d+);", text)]
        self.faces_per_cell = 2 * len(faces) / self.cells


def head(kind, name):
    return f"FoamFile {{ version 2.0; format ascii; class {kind}; object {name}; }}\n"


def write(path, text):
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text(text)


def solve(case, correctors):
    """Errors (L2, by volume) of the values and gradients, and how many iterations it took."""
    case = Path(case)
    mesh = Mesh(case)
    write(case / "system/controlDict", head("dictionary", "controlDict") + "application laplacianFoam; startFrom startTime;"
          " startTime 0; stopAt endTime; endTime 1; deltaT 1; writeControl timeStep; writeInterval 1; writeFormat ascii;"
          " writePrecision 15; timeFormat general; runTimeModifiable false;\n")
    write(case / "system/fvSchemes", head("dictionary", "fvSchemes") + "ddtSchemes { default steadyState; } gradSchemes { default"
          " leastSquares; grad(T) leastSquares; } divSchemes { default none; } laplacianSchemes { default Gauss linear"
          " corrected; } interpolationSchemes { default linear; } snGradSchemes { default corrected; }\n")
    write(case / "system/fvSolution", head("dictionary", "fvSolution") + "solvers { T { solver PCG; preconditioner DIC;"
          f" tolerance 1e-11; relTol 0; }} }} SIMPLE {{ nNonOrthogonalCorrectors {correctors}; }}\n")
    write(case / "constant/transportProperties", head("dictionary", "transportProperties") + "DT DT [0 2 -1 0 0 0 0] 1;\n")
    fields = []
    for name, count, start in mesh.patches:
        values = "\n".join(repr(float(value)) for value in exact(mesh.centers[start:start + count]))
        fields.append(f"{name} {{ type fixedValue; value nonuniform List<scalar> {count} ( {values} ); }}")
    write(case / "0/T", head("volScalarField", "T") + "dimensions [0 0 0 1 0 0 0]; internalField uniform 0;\nboundaryField {\n"
          + "\n".join(fields) + "\n}\n")
    shutil.rmtree(case / "1", ignore_errors=True)
    log = call("laplacianFoam", "-case", case)
    iterations = sum(int(n) for n in re.findall(r"No Iterations (\d+)", log))
    call("postProcess", "-case", case, "-func", "grad(T)", "-time", "1")
    weight = mesh.volumes / mesh.volumes.sum()
    value = field(case / "1/T", 1).ravel() - exact(mesh.centroids)
    gradient = field(case / "1/grad(T)", 3) - exact_gradient(mesh.centroids)
    return {"cells": mesh.cells, "faces": mesh.faces_per_cell, "iterations": iterations,
            "value": math.sqrt((weight * value ** 2).sum()),
            "gradient": math.sqrt((weight * (gradient ** 2).sum(axis=1)).sum())}


def field(path, width):
    text = entries(path)
    text = text[text.index("internalField"):text.index("boundaryField")]
    body = text[text.index("(") + 1:text.rindex(")")]
    return np.array(re.sub(r"[()]", " ", body).split(), float).reshape(-1, width)


# --- ours ---

def ours(program, work, name, count, surface, collapse, moves):
    """Relaxes as many cells and meshes them: in solids a lattice by Lloyd's moves, or where there are none as
    `relax --goal mesh` does; in the box random sites."""
    run, case = work / f"{name}-run", work / f"{name}-cells-{collapse}"
    if not (run / "sites.csv").exists():
        start = ["--count", count, "--method", "quasi-newton", "--iterations", 200]
        if surface and moves:
            start = [work / f"{name}.json"]
            sites = {"random": {"count": count, "seed": 1, "lattice": True}}
            write(start[0], json.dumps({"domain": {"surface": str(surface)}, "sites": sites, "method": {"lloyd": {"iterations": moves}}}))
        elif surface:
            start = [surface, "--count", count, "--goal", "mesh"]
        call(program, "relax", *start, "--out", run, "--no-cells-file", "--no-pictures", "--quiet", "--force")
    if not (case / "mesh.json").exists():
        call(program, "mesh", run, "-o", case, "--collapse", collapse, "--quiet", "--force")
        call("renumberMesh", "-case", case, "-overwrite")
    return case


# --- Gmsh ---

def read_off(path):
    words = Path(path).read_text().split()
    points, faces = int(words[1]), int(words[2])
    vertices = np.array(words[4:4 + 3 * points], float).reshape(-1, 3)
    return vertices, np.array(words[4 + 3 * points:4 + 3 * points + 4 * faces], int).reshape(-1, 4)[:, 1:]


def write_off(path, vertices, triangles):
    lines = ["OFF", f"{len(vertices)} {len(triangles)} 0"]
    lines += [" ".join(repr(float(x)) for x in vertex) for vertex in vertices]
    Path(path).write_text("\n".join(lines + [f"3 {a} {b} {c}" for a, b, c in triangles]) + "\n")


def write_stl(path, vertices, triangles):
    lines = ["solid s"]
    for triangle in triangles:
        lines.append("facet normal 0 0 0\nouter loop")
        lines += ["vertex " + " ".join(repr(float(x)) for x in vertices[corner]) for corner in triangle]
        lines.append("endloop\nendfacet")
    Path(path).write_text("\n".join(lines + ["endsolid s\n"]))


def tets(path, surface, size):
    """Gmsh's tetrahedra with edges of a length, optimized by Gmsh and Netgen; (tetrahedra, points)."""
    import gmsh
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 1)
    if surface is None:
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
    else:
        stl = str(path) + ".stl"
        write_stl(stl, *read_off(surface))
        gmsh.merge(stl)
        gmsh.model.mesh.classifySurfaces(math.radians(40), True, True, math.radians(180))
        gmsh.model.mesh.createGeometry()
        gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop([tag for _, tag in gmsh.model.getEntities(2)])])
        gmsh.model.geo.synchronize()
    for option in ["MeshSizeMin", "MeshSizeMax"]:
        gmsh.option.setNumber(f"Mesh.{option}", size)
    gmsh.model.addPhysicalGroup(2, [tag for _, tag in gmsh.model.getEntities(2)], name="walls")
    gmsh.model.addPhysicalGroup(3, [tag for _, tag in gmsh.model.getEntities(3)], name="inside")
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.optimize("Netgen")
    elements = gmsh.model.mesh.getElements(3)[1]
    counts = sum(len(tags) for tags in elements), len(gmsh.model.mesh.getNodes()[0])
    gmsh.write(str(path))
    gmsh.finalize()
    return counts


def of_gmsh(work, name, count, surface, volume, place):
    """A case of tetrahedra of which there are about `count` (place 0), or points (place 1)."""
    case = work / f"{name}-{['tets', 'dual'][place]}"
    if (case / "constant/polyMesh/owner").exists():
        return case
    size = (volume / count * [8.0, 1.2][place]) ** (1 / 3)
    case.mkdir(parents=True, exist_ok=True)
    tried = {}
    for _ in range(6):  # counts jump with the edges along a side
        tried[size] = tets(case / "m.msh", surface, size)[place] / count
        best = min(tried, key=lambda size: abs(math.log(tried[size])))
        if abs(tried[best] - 1) < 0.03:
            break
        size *= tried[size] ** (0.6 / 3)
    if size != best:
        tets(case / "m.msh", surface, best)
    write(case / "system/controlDict", head("dictionary", "controlDict") + "application a; startFrom startTime; startTime 0; stopAt"
          " endTime; endTime 1; deltaT 1; writeControl timeStep; writeInterval 1; writeFormat ascii; writePrecision 15;\n")
    write(case / "system/fvSchemes", head("dictionary", "fvSchemes") + "gradSchemes {} divSchemes {} laplacianSchemes {}\n")
    write(case / "system/fvSolution", head("dictionary", "fvSolution"))
    call("gmshToFoam", "m.msh", "-case", case, cwd=case)
    if place == 1:
        call("polyDualMesh", "-case", case, "-overwrite", 45)
    call("renumberMesh", "-case", case, "-overwrite")
    return case


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--sizes", default="10,20", help="cells along an edge of the unit box [10,20]")
    options.add_argument("--solids", default="bracket,torus", help="names in scenes/, or .off files, each with =COUNT")
    options.add_argument("--collapse", default="0,0.1", help="collapses of ours [0,0.1]")
    options.add_argument("--correctors", type=int, default=8, help="non-orthogonal correctors [8]")
    options.add_argument("--no-dual", action="store_true", help="without polyDualMesh")
    options.add_argument("--moves", type=int, help="Lloyd's moves of a lattice in solids; 0: --goal mesh instead [200, bracket 0]")
    options.add_argument("--work", type=Path, default=Path("solvers"), help="where meshes are kept [solvers]")
    options.add_argument("--chebloyd", default="chebloyd", help="the program")
    options = options.parse_args()
    options.work = options.work.resolve()
    options.work.mkdir(parents=True, exist_ok=True)
    jobs = [(f"box-{n}", int(n) ** 3, None, 1.0) for n in options.sizes.split(",") if n]
    for word in filter(None, options.solids.split(",")):
        word, _, count = word.partition("=")
        path = Path(word) if word.endswith(".off") else SCENES / f"{word}.off"
        vertices, triangles = read_off(path)
        low, high = vertices.min(axis=0), vertices.max(axis=0)  # into the middle of the unit cube
        vertices = 0.5 + (vertices - 0.5 * (low + high)) / (high - low).max()
        name, path = path.stem, options.work / path.name
        write_off(path, vertices, triangles)
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        volume = abs((a * np.cross(b, c)).sum() / 6)
        jobs.append((name, int(count or {"bracket": 1000}.get(name, 5000)), path, volume))
    print("| mesh | cells | faces per cell | value | gradient | iterations | tets over this: value | gradient |\n|---|---|---|---|---|---|---|---|")
    for name, count, surface, volume in jobs:
        cases = []
        # Straight solids keep the lattice's rows; on curved ones Lloyd's cells are better to solve on than hexahedra.
        moves = {"bracket": 0}.get(name, 200) if options.moves is None else options.moves
        for collapse in options.collapse.split(","):
            cases.append((f"{name}, ours, collapse {collapse}", ours(
                options.chebloyd, options.work, name, count, surface, collapse, moves)))
        reached = Mesh(cases[0][1]).cells
        if not options.no_dual:
            cases.append((f"{name}, polyDualMesh", of_gmsh(options.work, name, reached, surface, volume, 1)))
        cases.append((f"{name}, tets", of_gmsh(options.work, name, reached, surface, volume, 0)))
        rows = [(label, solve(case, options.correctors)) for label, case in cases]
        last = rows[-1][1]
        for label, row in rows:
            print(f"| {label} | {row['cells']} | {row['faces']:.1f} | {row['value']:.2e} | {row['gradient']:.2e} | {row['iterations']} | "
                  f"{last['value'] / row['value']:.2f} | {last['gradient'] / row['gradient']:.2f} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
