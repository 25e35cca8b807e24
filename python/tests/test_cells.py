"""Cells: identities, SciPy's Voronoi of images, other packages' forms, chosen ones among ghosts."""

import chebloyd
import numpy as np
import pytest
from chebloyd import Box

RNG = np.random.default_rng(3)
POINTS = RNG.random((400, 3))
LONG = Box((-1, 0, 2), (1, 1, 2.5), periodic=(True, False, True))
LONG_POINTS = np.array([-1, 0, 2]) + RNG.random((300, 3)) * [2, 1, 0.5]


@pytest.mark.parametrize(
    ("points", "domain", "volume"),
    [
        (POINTS, Box(), 1),
        (POINTS, Box(periodic=True), 1),
        (LONG_POINTS, LONG, 1),
        (np.indices((5, 5, 5)).reshape(3, -1).T / 5 + 0.1, Box(periodic=True), 1),
        (np.indices((5, 5, 5)).reshape(3, -1).T / 5 + 0.1 + RNG.random((125, 3)) * 1e-9, Box(), 1),
        (POINTS[:1], Box(periodic=True), 1),
        (POINTS[:2], Box(), 1),
        (np.c_[POINTS[:50, :2], np.full(50, 0.5)], Box(), 1),
        (POINTS[(POINTS.sum(1) < 1)], chebloyd.HalfSpaces(np.vstack((np.c_[-np.eye(3), np.zeros(3)], [1, 1, 1, 1]))), 1 / 6),
    ],
)
def test_cells_fill_the_domain_and_their_facets_close(points, domain, volume):
    cells = chebloyd.cells(points, domain=domain)
    assert len(cells) == len(points) and cells.certified.all()
    assert abs(cells.volumes.sum() - volume) < 1e-12
    owner = cells.owners()
    # The divergence theorem: Σ A n = 0, and 3 V = Σ A h, h the height of the facet's plane.
    gap = np.zeros((len(cells), 3))
    np.add.at(gap, owner, cells.areas[:, None] * cells.normals)
    # Slivers of a lattice moved by 1e-9 have normals that are known to as much.
    assert np.abs(gap).max() < 1e-10
    assert np.abs(np.linalg.norm(cells.normals, axis=1) - 1).max() < 1e-12
    first = cells.vertices[cells.corners[cells.corner_offsets[:-1]]]
    heights = ((first - cells.centroids[owner]) * cells.normals).sum(1)
    assert np.abs(np.bincount(owner, cells.areas * heights) / 3 - cells.volumes).max() < 1e-12
    # V − E + F = 2 for every cell: each edge belongs to two facets.
    vertices, facets = np.diff(cells.vertex_offsets), np.diff(cells.facet_offsets)
    edges = np.bincount(owner, np.diff(cells.corner_offsets)) / 2
    assert (vertices - edges + facets == 2).all()
    # Facets are seen from both sides, with opposite images.
    inner = cells.neighbors >= 0
    sides = {}
    for i, j, image, area in zip(owner[inner], cells.neighbors[inner], cells.images[inner], cells.areas[inner]):
        sides[i, j, *image.tolist()] = area
    large = {side: area for side, area in sides.items() if area > 1e-8}
    for (i, j, a, b, c), area in large.items():
        assert abs(sides[j, i, -a, -b, -c] - area) < 1e-9
    # Every bisector lies halfway: the vector to the neighbor is along the normal.
    i, j, vectors, areas = cells.neighbor_list()
    order = np.lexsort((cells.neighbors[inner], owner[inner]))
    normals = cells.normals[inner][order]
    assert (np.abs((vectors * normals).sum(1) - np.linalg.norm(vectors, axis=1)) < 1e-9).all() and len(areas) == inner.sum()


def test_interior_cells_are_scipys():
    from_scipy = pytest.importorskip("scipy.spatial")
    shifts = np.stack(np.meshgrid(*[[0, -1, 1]] * 3, indexing="ij"), -1).reshape(-1, 3)
    points = POINTS[:100]
    images = (points[None] + shifts[:, None]).reshape(-1, 3)
    theirs = from_scipy.Voronoi(images)
    cells = chebloyd.cells(points, domain=Box(periodic=True))
    for site in range(100):
        region = theirs.vertices[theirs.regions[theirs.point_region[site]]]
        assert abs(from_scipy.ConvexHull(region).volume - cells.volumes[site]) < 1e-12
        assert len(region) == len(cells.polytope(site))
    pairs = {(i, j % 100) for i, j in theirs.ridge_points if i < 100}
    pairs |= {(j, i % 100) for i, j in theirs.ridge_points if j < 100}
    assert pairs == set(map(tuple, cells.edges().tolist()))


def test_chosen_cells_have_the_bits_of_all_and_thin_halos_are_noticed():
    points = RNG.random((4000, 3))
    for domain in (Box(), Box(periodic=True)):
        whole = chebloyd.cells(points, domain=domain)
        own = np.flatnonzero((points < 0.5).all(1))
        among_all = chebloyd.cells(points, domain=domain, select=own, known="all")
        assert among_all.certified.all() and (among_all.volumes == whole.volumes[own]).all()
        mask = np.zeros(4000, bool)
        mask[own] = True
        assert (chebloyd.cells(points, domain=domain, select=mask).areas == among_all.areas).all()
        assert (chebloyd.cells(points, domain=domain, select=own[::-1]).volumes == whole.volumes[own][::-1]).all()
        outcomes = []
        for halo in (0.03, 0.1, 0.3):
            low = np.full(3, -halo if domain.periodic else 0.0)
            wrapped = (points + halo) % 1 - halo if domain.periodic else points
            near = np.flatnonzero((wrapped <= 0.5 + halo).all(1))
            numbers = np.flatnonzero((points[near] < 0.5).all(1))
            known = Box(low, [0.5 + halo] * 3)
            ours = chebloyd.cells(points[near], domain=domain, select=numbers, known=known)
            assert (near[numbers] == own).all()
            right = np.abs(ours.volumes - whole.volumes[own]) < 1e-14
            assert right[ours.certified].all()
            assert (near[ours.neighbors[ours.neighbors >= 0]] < 4000).all()
            # By distances: all points nearer than these are given.
            inside = np.minimum(0.5 + halo - points[own], np.inf if not domain.periodic else points[own] + halo).min(1)
            by_distance = chebloyd.cells(points[near], domain=domain, select=numbers, known=inside)
            assert (by_distance.certified <= ours.certified).all()
            # Nothing said: what the points themselves span, however they are wrapped.
            for given in (points[near], wrapped[near]):
                spanned = chebloyd.cells(given, domain=domain, select=numbers)
                assert (spanned.certified <= ours.certified).all() and right[spanned.certified].all()
            outcomes.append((right.mean(), ours.certified.mean()))
        (thin, few), _, (wide, all_) = outcomes
        assert thin < 1 and few < 0.9 and wide == 1 and all_ == 1


def test_a_radius_is_how_far_a_cell_looks():
    cells = chebloyd.cells(POINTS)
    for site in range(0, 400, 40):
        # Nothing beyond the radius matters.
        near = np.flatnonzero(np.linalg.norm(POINTS - POINTS[site], axis=1) <= cells.radii[site] * (1 + 1e-12))
        alone = chebloyd.cells(POINTS[near], select=[int(np.flatnonzero(near == site)[0])])
        assert abs(alone.volumes[0] - cells.volumes[site]) < 1e-14
        farthest = np.linalg.norm(cells.polytope(site) - POINTS[site], axis=1).max()
        assert abs(2 * farthest - cells.radii[site]) < 1e-12


def test_cells_of_the_plane():
    points = RNG.random((150, 2))
    for domain in (None, Box((0, 0), (1, 1), periodic=(False, True)), chebloyd.HalfSpaces([[-1, 0, 0], [0, -1, 0], [1, 1, 2]])):
        cells = chebloyd.cells(points, domain=domain)
        area = 2 if isinstance(domain, chebloyd.HalfSpaces) else 1
        assert abs(cells.volumes.sum() - area) < 1e-12 and cells.images.shape[1] == 2
        gap = np.zeros((150, 2))
        np.add.at(gap, cells.owners(), cells.areas[:, None] * cells.normals)
        assert np.abs(gap).max() < 1e-12
        some = chebloyd.cells(points, domain=domain, select=[7, 3], known="all")
        assert (some.volumes == cells.volumes[[7, 3]]).all() and some.certified.all()
    ring = chebloyd.Polygon([[[0, 0], [4, 0], [4, 4], [0, 4]], [[1, 1], [3, 1], [3, 3], [1, 3]]])
    inside = points * 4
    inside = inside[~((inside > 1) & (inside < 3)).all(1)]
    assert abs(chebloyd.cells(inside, domain=ring).volumes.sum() - 12) < 1e-12
    figures = chebloyd.measure(inside, domain=ring)["cells"]
    assert np.abs(figures["centroid"] - chebloyd.cells(inside, domain=ring).centroids).max() < 1e-12


def test_meshes_given_as_arrays_are_domains():
    vertices = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = np.array([[a, b, c] for a, b, c, _ in quads] + [[a, c, d] for a, _, c, d in quads])
    solid = chebloyd.Surface((vertices, triangles))
    sites = POINTS[:50]
    cells = chebloyd.cells(sites, domain=solid)
    assert np.abs(cells.volumes - chebloyd.cells(sites).volumes).max() < 1e-12
    gap = np.zeros((50, 3))
    np.add.at(gap, cells.owners(), cells.areas[:, None] * cells.normals)
    assert np.abs(gap).max() < 1e-9
    relaxed = chebloyd.relax(sites, domain=solid, iterations=3)
    assert np.abs(relaxed.sites - chebloyd.relax(sites, iterations=3).sites).max() < 1e-9
    tets = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])
    assert abs(chebloyd.measure(sites, domain=chebloyd.Tets((vertices, tets))).volume_sum - 1) < 1e-12
    properties = chebloyd.mass((vertices, triangles), density="1 + x")
    assert abs(properties.mass - 1.5) < 1e-14 and abs(properties.center_of_mass[0] - 5 / 9) < 1e-14
    with pytest.raises(ValueError, match="name vertices"):
        chebloyd.mass((vertices, triangles + 1))


def test_what_is_not_there_is_said():
    with pytest.raises(ValueError, match="power diagram"):
        chebloyd.cells(POINTS, weights=np.ones(400))
    with pytest.raises(ValueError, match="power diagram"):
        chebloyd.cells(POINTS, radii=np.ones(400))
    with pytest.raises(ValueError, match="triclinic"):
        chebloyd.cells(POINTS, domain=[[1, 0, 0], [0.2, 1, 0], [0, 0, 1]])
    with pytest.raises(ValueError, match="there is no site 400 among 400"):
        chebloyd.cells(POINTS, select=[400])
    with pytest.raises(ValueError, match="there is no site -1"):
        chebloyd.cells(POINTS, select=[-1])
    with pytest.raises(ValueError, match="duplicates"):
        chebloyd.cells(np.vstack((POINTS, POINTS[:1])))
    with pytest.raises(ValueError, match="shapes=True"):
        chebloyd.cells(POINTS, shapes=False).to_pyvoro()


def test_without_shapes_everything_else_is_the_same():
    whole, bare = chebloyd.cells(POINTS), chebloyd.cells(POINTS, shapes=False)
    assert (whole.areas == bare.areas).all() and (whole.neighbors == bare.neighbors).all() and len(bare.vertices) == 0


def test_pyvoros_dicts():
    cells = chebloyd.cells(LONG_POINTS, domain=LONG)
    dicts = cells.to_pyvoro()
    for cell in dicts[:20]:
        assert set(cell) == {"original", "volume", "vertices", "adjacency", "faces"}
        assert all(len(others) == 3 for others in cell["adjacency"])
        for one, others in enumerate(cell["adjacency"]):
            assert all(one in cell["adjacency"][other] for other in others)
    walls = {face["adjacent_cell"] for cell in dicts for face in cell["faces"] if face["adjacent_cell"] < 0}
    assert walls == {-3, -4}
    pyvoro2 = pytest.importorskip("pyvoro2")
    box = pyvoro2.OrthorhombicCell(((-1, 1), (0, 1), (2, 2.5)), periodic=(True, False, True))
    theirs = pyvoro2.compute(LONG_POINTS, domain=box, output="cells")
    theirs = sorted(theirs, key=lambda cell: cell["id"])
    for ours, other in zip(dicts, theirs, strict=True):
        assert abs(ours["volume"] - other["volume"]) < 1e-9
        both = [sorted(face["adjacent_cell"] for face in cell["faces"]) for cell in (ours, other)]
        assert [n for n in both[0] if n >= 0] == [n for n in both[1] if n >= 0]


def test_freuds_neighbor_list():
    freud = pytest.importorskip("freud")
    box = freud.box.Box(2, 3, 4)
    points = (RNG.random((200, 3)) - 0.5) * [2, 3, 4]
    ours = chebloyd.cells(points, domain=box).to_freud()
    voronoi = freud.locality.Voronoi().compute((box, points))
    theirs = voronoi.nlist

    def large(nlist):
        # freud computes in single precision: facets of no size come and go.
        keys = map(tuple, np.column_stack((nlist[:], np.round(nlist.vectors))).astype(int))
        return {key: float(area) for key, area in zip(keys, nlist.weights) if area > 1e-3}

    ours, theirs = large(ours), large(theirs)
    assert len(ours) > 2500 and all(abs(area - theirs[key]) < 1e-4 for key, area in ours.items() if area > 2e-3)
    assert all(key in ours for key, area in theirs.items() if area > 2e-3)
    with pytest.raises(ValueError, match="triclinic"):
        chebloyd.cells(points, domain=freud.box.Box(2, 3, 4, 0.1, 0, 0))


def test_pyvistas_and_meshios_grids(tmp_path):
    cells = chebloyd.cells(POINTS)
    flat = chebloyd.cells(RNG.random((50, 2)))
    pyvista = pytest.importorskip("pyvista")
    grid = cells.to_pyvista()
    assert grid.n_cells == 400 and grid.n_points == len(cells.vertices)
    # VTK's volumes differ in the fourth digit.
    assert np.abs(grid.compute_cell_sizes()["Volume"] / cells.volumes - 1).max() < 1e-2
    assert grid.get_cell(7).n_faces == np.diff(cells.facet_offsets)[7]
    planar = flat.to_pyvista()
    assert np.abs(planar.compute_cell_sizes()["Area"] - flat.volumes).max() < 1e-12
    meshio = pytest.importorskip("meshio")
    mesh = cells.to_meshio()
    assert sum(len(block.data) for block in mesh.cells) == 400
    assert abs(sum(values.sum() for values in mesh.cell_data["volume"]) - 1) < 1e-12
    mesh.write(tmp_path / "cells.vtu")
    assert pyvista.read(tmp_path / "cells.vtu").n_cells == 400
    assert sum(len(block.data) for block in flat.to_meshio().cells) == 50
