"""Voronoi cells as flat arrays, and in the forms that other packages use."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from ._meshes import Files
from ._native import native
from ._scene import Box, Domain, points_of, scene_text

if TYPE_CHECKING:
    import freud
    import meshio
    import pyvista
    from numpy.typing import ArrayLike, NDArray

Floats: TypeAlias = "NDArray[np.float64]"
Ints: TypeAlias = "NDArray[np.int64]"


@dataclass(frozen=True, repr=False)
class Cells:
    """Cells of n sites as flat arrays; D = 3 coordinates in space, 2 in the plane.

    V corners, F facets (polygons; edges in the plane) and their C corner numbers stand one cell after the
    other. Lengths are in the unit of the sites (L). Facets that shrink
    to an edge or a corner (within 1e-10 of the cell) are left out.
    """

    #: The sites whose cells these are, by their index in the points: (n,).
    select: Ints
    #: Their positions as given: (n, D) (L).
    points: Floats
    #: Corners: (V, D) (L). Cell i has ``vertices[vertex_offsets[i]:vertex_offsets[i + 1]]``.
    vertices: Floats
    #: (n + 1,).
    vertex_offsets: Ints
    #: The facets' corners by row of ``vertices``, counter-clockwise from outside: (C,).
    corners: Ints
    #: Facet k has ``corners[corner_offsets[k]:corner_offsets[k + 1]]``: (F + 1,).
    corner_offsets: Ints
    #: Cell i has the facets from ``facet_offsets[i]`` to ``facet_offsets[i + 1]``: (n + 1,).
    facet_offsets: Ints
    #: The point behind each facet, by index; −1 − k beyond wall k (of a box −x, +x, −y, +y, −z, +z): (F,).
    neighbors: Ints
    #: By how many periods along each axis that neighbor is moved: (F, D).
    images: NDArray[np.int8]
    #: Areas (L²), in the plane lengths (L): (F,).
    areas: Floats
    #: Outward unit normals: (F, D).
    normals: Floats
    #: Volumes (L³), in the plane areas (L²): (n,).
    volumes: Floats
    #: Centroids: (n, D) (L).
    centroids: Floats
    #: How far each cell asks for neighbors: points farther from its own cannot change it (L): (n,).
    radii: Floats
    #: Whether all points that can change the cell are known to be given: (n,).
    certified: NDArray[np.bool_]
    #: The period along each axis, 0 where there is none: (D,) (L).
    periods: Floats
    #: What was repaired in the domain's mesh, one sentence each.
    notes: list[str] = field(default_factory=list)

    def __len__(self) -> int:
        """How many cells there are."""
        return len(self.volumes)

    def __repr__(self) -> str:
        return f"<{len(self)} cells, {len(self.areas)} facets, {len(self.vertices)} vertices>"

    @property
    def faces(self) -> Ints:
        """The facets as VTK and PyVista list them: the number of corners, the corners, and so on: (C + F,)."""
        sizes = np.diff(self.corner_offsets)
        return np.insert(self.corners, self.corner_offsets[:-1], sizes)

    def facets(self, cell: int) -> slice:
        """The facets of a cell, to index ``areas``, ``neighbors``, ``normals`` and ``images``."""
        return slice(int(self.facet_offsets[cell]), int(self.facet_offsets[cell + 1]))

    def polytope(self, cell: int) -> Floats:
        """The corners of a cell (k, D), as freud's ``polytopes`` has them."""
        self._need_shapes()
        return self.vertices[self.vertex_offsets[cell] : self.vertex_offsets[cell + 1]]

    def owners(self) -> Ints:
        """The cell of each facet: (F,)."""
        return np.repeat(np.arange(len(self)), np.diff(self.facet_offsets))

    def edges(self) -> Ints:
        """Pairs (i, j) of indices of neighboring points, a row per facet, walls left out: (m, 2)."""
        inner = self.neighbors >= 0
        return np.column_stack((self.select[self.owners()][inner], self.neighbors[inner]))

    def neighbor_list(self) -> tuple[Ints, Ints, Floats, Floats]:
        """``(i, j, vectors, areas)`` of all facets between points, ordered by i and j as freud orders them.

        ``vectors`` (m, D) lead from point i to the image of point j behind the facet.
        """
        inner = np.flatnonzero(self.neighbors >= 0)
        cell = self.owners()[inner]
        i, j = self.select[cell], self.neighbors[inner]
        order = np.lexsort((j, i))
        inner, cell, i, j = inner[order], cell[order], i[order], j[order]
        # A bisector lies halfway: twice its distance along the normal leads to the neighbor.
        vectors = self._all_points[j] - self._all_points[i] + self._shifts(inner, i, j)
        return i, j, vectors, self.areas[inner]

    def _shifts(self, facets: Ints, i: Ints, j: Ints) -> Floats:
        """By how much neighbors are moved, of points that may lie outside the first period."""
        images = self.images[facets].astype(np.float64)
        periodic = self.periods > 0
        for axis in np.flatnonzero(periodic):
            copies = np.floor((self._all_points[:, axis] - self._origin[axis]) / self.periods[axis])
            images[:, axis] += copies[i] - copies[j]
        shifts: Floats = images * self.periods
        return shifts

    def to_freud(self) -> freud.locality.NeighborList:
        """freud's neighbor list, weighted by the facets' areas as ``freud.locality.Voronoi`` weights it."""
        import freud

        i, j, vectors, areas = self.neighbor_list()
        if self.vertices.shape[1] == 2:
            vectors = np.column_stack((vectors, np.zeros(len(vectors))))
        count = len(self._all_points)
        return freud.locality.NeighborList.from_arrays(count, count, i, j, vectors, areas)

    def to_pyvista(self) -> pyvista.UnstructuredGrid:
        """PyVista's grid, a polyhedron (in the plane a polygon) per cell, with ``site`` and ``volume``.

        VTK computes volumes by a rule of its own and differs in the fourth digit: take those in ``volume``.
        """
        import pyvista

        self._need_shapes()
        if self.vertices.shape[1] == 2:
            cells, kind, points = self._polygons(), pyvista.CellType.POLYGON, _lifted(self.vertices)
        else:
            cells, kind, points = self._polyhedra(), pyvista.CellType.POLYHEDRON, self.vertices
        grid = pyvista.UnstructuredGrid(cells, np.full(len(self), kind, np.uint8), points)
        grid.cell_data["site"] = self.select
        grid.cell_data["volume"] = self.volumes
        return grid

    def _polyhedra(self) -> Ints:
        """Per cell: how many numbers follow, how many facets, the facets as in ``faces``."""
        starts = self.corner_offsets + np.arange(len(self.corner_offsets))
        starts = starts[self.facet_offsets]
        sizes, counts = np.diff(starts) + 1, np.diff(self.facet_offsets)
        heads = np.column_stack((sizes, counts)).ravel()
        return np.insert(self.faces, np.repeat(starts[:-1], 2), heads)

    def _polygons(self) -> Ints:
        """Per cell: how many corners, the corners. Cells in several pieces have none that are one polygon."""
        sizes = np.diff(self.vertex_offsets)
        if not np.array_equal(sizes, np.diff(self.facet_offsets)):
            raise ValueError("cells clipped to a polygon that is not convex are in pieces and no polygons")
        return np.insert(np.arange(len(self.vertices)), self.vertex_offsets[:-1], sizes)

    def to_meshio(self) -> meshio.Mesh:
        """meshio's mesh: blocks of ``polyhedronN``, in the plane of ``polygon``, with ``site`` and ``volume``."""
        import meshio

        self._need_shapes()
        groups: dict[str, list[int]] = {}
        blocks: list[tuple[str, Any]] = []
        flat = self.vertices.shape[1] == 2
        for cell, size in enumerate(np.diff(self.vertex_offsets).tolist()):
            groups.setdefault(f"polygon{size}" if flat else f"polyhedron{size}", []).append(cell)
        for kind, members in groups.items():
            if flat:
                size = int(kind.removeprefix("polygon"))
                rows = self.vertex_offsets[members][:, None] + np.arange(size)
                blocks.append(("polygon", rows))
            else:
                blocks.append((kind, [self._loops(cell) for cell in members]))
        lists = list(groups.values())
        data = {"site": [self.select[m] for m in lists], "volume": [self.volumes[m] for m in lists]}
        return meshio.Mesh(_lifted(self.vertices) if flat else self.vertices, blocks, cell_data=data)

    def _loops(self, cell: int) -> list[Ints]:
        """The corners of a cell's facets, by row of ``vertices``."""
        first, end = self.facet_offsets[cell : cell + 2].tolist()
        ends = self.corner_offsets[first : end + 1].tolist()
        return [self.corners[a:b] for a, b in zip(ends, ends[1:])]

    def to_pyvoro(self) -> list[dict[str, Any]]:
        """pyvoro's list of dicts: ``original``, ``volume``, ``vertices``, ``adjacency``, ``faces``.

        ``faces`` have ``adjacent_cell`` (−1 … −6 are a box's walls, as in Voro++) and ``vertices``, numbers in
        the cell's own list.
        """
        self._need_shapes()
        return [self._as_pyvoro(cell) for cell in range(len(self))]

    def _as_pyvoro(self, cell: int) -> dict[str, Any]:
        first = int(self.vertex_offsets[cell])
        vertices = self.polytope(cell).tolist()
        loops = [(loop - first).tolist() for loop in self._loops(cell)]
        around: list[set[int]] = [set() for _ in vertices]
        for loop in loops:
            for one, other in zip(loop, loop[1:] + loop[:1]):
                around[one].add(other)
                around[other].add(one)
        beyond = self.neighbors[self.facets(cell)].tolist()
        faces = [{"adjacent_cell": n, "vertices": loop} for n, loop in zip(beyond, loops)]
        return {
            "original": self.points[cell].tolist(),
            "volume": float(self.volumes[cell]),
            "vertices": vertices,
            "adjacency": [sorted(others) for others in around],
            "faces": faces,
        }

    def _need_shapes(self) -> None:
        if len(self.vertices) == 0:
            raise ValueError("the cells were made without shapes; say shapes=True")

    @property
    def _all_points(self) -> Floats:
        points: Floats = self.__dict__["_given"]
        return points

    @property
    def _origin(self) -> Floats:
        origin: Floats = self.__dict__["_low"]
        return origin


def _lifted(points: Floats) -> Floats:
    """Points of the plane in space."""
    return np.column_stack((points, np.zeros(len(points))))


def cells(
    points: ArrayLike,
    *,
    domain: Domain = None,
    select: ArrayLike | None = None,
    known: Box | float | ArrayLike | Literal["all"] | None = None,
    shapes: bool = True,
    weights: ArrayLike | None = None,
    radii: ArrayLike | None = None,
    threads: int | None = None,
) -> Cells:
    """The Voronoi cells of ``points`` (n, 3), in the plane (n, 2), clipped to ``domain`` (the unit cube).

    ``select`` asks for the cells of some points only, by index or as a mask: one's own among ghosts. Such a cell
    is right if all points within its radius are given, and ``known`` says where they are: within a ``Box``, or
    within a distance of each chosen point (a number, or one for each); ``"all"`` says that there are no others.
    Left out, it is the least box around the points given (along periodic axes, all but the widest gap).
    ``certified`` then says which cells are right for sure. Without ``select`` and ``known`` the points are all there are.

    ``shapes=False`` leaves out corners, for neighbors, areas and volumes alone. Points weigh alike: ``weights``
    and ``radii`` (power diagrams) are refused, and so are triclinic boxes. Raises ``ValueError``, also where
    two points lie in one place.
    """
    if weights is not None or radii is not None:
        raise ValueError(
            "weights and radii make a power diagram, which chebloyd does not build: its cells are those of points "
            "that weigh alike"
        )
    given = points_of(points)
    chosen = None if select is None else _chosen(select, len(given))
    with Files() as files:
        text = scene_text(given.shape[1], domain, files, {})
        low, periods = _periods(text, given.shape[1])
        box, distance = _known(known, given, chosen, (low, periods))
        arrays, notes = native.cells(text, _wrapped(given, low, periods), chosen, box, shapes, threads)
    if chosen is None:
        chosen = np.arange(len(given))
    if distance is not None:
        arrays["certified"] = np.asarray(arrays["radii"] <= distance)
    found = Cells(select=chosen, points=given[chosen], periods=periods, notes=notes, **arrays)
    found.__dict__["_given"], found.__dict__["_low"] = given, low
    return found


def _chosen(select: ArrayLike, count: int) -> Ints:
    chosen = np.asarray(select)
    if chosen.dtype == np.bool_:
        if chosen.shape != (count,):
            raise ValueError(f"the mask has shape {chosen.shape}, and there are {count} points")
        return np.flatnonzero(chosen)
    if chosen.ndim != 1 or chosen.size and chosen.dtype.kind not in "iu":
        raise ValueError(f"select is {chosen.dtype} of shape {chosen.shape}; indices (k,) or a mask are needed")
    return chosen.astype(np.int64)


def _known(
    known: Any, points: Floats, chosen: Ints | None, periodic: tuple[Floats, Floats]
) -> tuple[list[list[float]] | None, float | Floats | None]:
    """The box in which all points are given, or how far from each chosen one; neither if that is everywhere."""
    if isinstance(known, str):
        if known != "all":
            raise ValueError(f"known is {known!r}; it can be a Box, distances or 'all'")
        return None, None
    if known is None and (chosen is None or len(points) == 0):
        return None, None
    if known is not None and not isinstance(known, Box):
        distances = np.asarray(known, dtype=np.float64)
        count = len(points) if chosen is None else len(chosen)
        if distances.shape not in ((), (count,)):
            raise ValueError(f"known has shape {distances.shape}; one distance, or ({count},), is needed")
        return None, distances
    corners = _spanned(points, *periodic) if known is None else [known.min, known.max]
    ends = [[float(x) for x in corner] for corner in corners]
    return [[*end, *[0.0] * (3 - len(end))] for end in ends], None


def _wrapped(points: Floats, low: Floats, periods: Floats) -> Floats:
    """Points within the first period; those given if they are there already."""
    for axis in np.flatnonzero(periods):
        along = points[:, axis]
        if ((along < low[axis]) | (along > low[axis] + periods[axis])).any():
            points = points.copy()
            points[:, axis] = low[axis] + (along - low[axis]) % periods[axis]
    return points


def _spanned(points: Floats, low: Floats, periods: Floats) -> list[Floats]:
    """The least box around points; along periodic axes what is left of a period without its largest gap."""
    least, most = points.min(axis=0), points.max(axis=0)
    for axis in np.flatnonzero(periods):
        period = periods[axis]
        sorted_ = np.sort((points[:, axis] - low[axis]) % period) + low[axis]
        gaps = np.diff(sorted_, append=sorted_[0] + period)
        widest = int(gaps.argmax())
        least[axis] = sorted_[(widest + 1) % len(sorted_)]
        most[axis] = least[axis] + period - gaps[widest]
    return [least, most]


def _periods(text: str, dimension: int) -> tuple[Floats, Floats]:
    """The least corner of a scene's box, and its period along each axis, 0 where there is none."""
    import json

    box = json.loads(text).get("domain", {}).get("box", {})
    low = np.array(box.get("min") or [0.0] * dimension, dtype=np.float64)
    high = np.array(box.get("max") or [1.0] * dimension, dtype=np.float64)
    periodic = np.array(box.get("periodic") or [False] * dimension, dtype=bool)
    return low, np.where(periodic, high - low, 0.0)
