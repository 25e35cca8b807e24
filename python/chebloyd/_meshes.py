"""Meshes and fields given as arrays and dicts: written into files as the program reads them."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, runtime_checkable

import numpy as np

if TYPE_CHECKING:
    import tempfile

    from numpy.typing import ArrayLike, NDArray


@runtime_checkable
class HasFaces(Protocol):
    """What trimesh and others call a mesh."""

    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...


#: A file; ``(vertices, triangles or tetrahedra)`` with shapes (n, 3) and (m, 3) or (m, 4); an object with
#: ``vertices`` and ``faces``, such as trimesh's; or PyVista's ``PolyData``.
Mesh: TypeAlias = "str | os.PathLike[str] | tuple[ArrayLike, ArrayLike] | HasFaces | Any"


class Files:
    """A folder for what is given as arrays, there while it is in use as a context."""

    def __init__(self) -> None:
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._count = 0

    def __enter__(self) -> Files:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._folder is not None:
            self._folder.cleanup()

    def path(self, name: str) -> Path:
        """A new file of this name."""
        if self._folder is None:
            import tempfile  # here: most calls need no folder, and it takes time to import

            self._folder = tempfile.TemporaryDirectory(prefix="chebloyd-")
        self._count += 1
        folder = Path(self._folder.name, str(self._count))
        folder.mkdir()
        return folder / name

    def mesh(self, mesh: Mesh) -> str:
        """The file of a mesh: its own, or a new one that holds its numbers to the last bit."""
        if isinstance(mesh, (str, os.PathLike)):
            return os.fspath(mesh)
        vertices, elements = _arrays(mesh)
        if elements.shape[1] == 4:
            path = self.path("tets.mesh")
            path.write_text(_medit(vertices, elements))
        else:
            path = self.path("surface.ply")
            path.write_bytes(_ply(vertices, elements))
        return str(path)

    def field(self, field: str | float | dict[str, Any]) -> str:
        """A density as the program's options take it."""
        if not isinstance(field, dict):
            return field if isinstance(field, str) else repr(float(field))
        path = self.path("field.json")
        path.write_text(json.dumps(field))
        return f"@{path}"

    def points(self, points: ArrayLike, name: str) -> str:
        """A ``.npy`` file of points."""
        path = self.path(name)
        np.save(path, np.asarray(points, dtype=np.float64))
        return str(path)


def _arrays(mesh: Any) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    if isinstance(mesh, tuple) and len(mesh) == 2:
        vertices, elements = mesh
    elif hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        vertices, elements = mesh.vertices, mesh.faces
    elif hasattr(mesh, "regular_faces"):
        vertices, elements = mesh.points, mesh.triangulate().regular_faces
    else:
        raise ValueError(
            f"a mesh is a file, (vertices, faces), or an object that has both; not {type(mesh).__name__}"
        )
    points = np.asarray(vertices, dtype=np.float64)
    numbers = np.asarray(elements)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"a mesh's vertices have shape {points.shape}; (n, 3) is needed")
    if numbers.ndim != 2 or numbers.shape[1] not in (3, 4) or numbers.dtype.kind not in "iu":
        raise ValueError(
            f"a mesh's elements are {numbers.dtype} of shape {numbers.shape}; integers of shape (m, 3), "
            "triangles, or (m, 4), tetrahedra, are needed"
        )
    if numbers.size and (numbers.min() < 0 or numbers.max() >= len(points)):
        raise ValueError(
            f"a mesh's elements name vertices {numbers.min()} to {numbers.max()}, and there are {len(points)}"
        )
    return points, numbers.astype(np.int64, copy=False)


def _ply(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> bytes:
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, triangles
    return head.encode() + vertices.astype("<f8").tobytes() + rows.tobytes()


def _medit(vertices: NDArray[np.float64], tets: NDArray[np.int64]) -> str:
    lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(vertices))]
    lines += [f"{x!r} {y!r} {z!r} 0" for x, y, z in vertices.tolist()]
    lines += ["Tetrahedra", str(len(tets))]
    lines += [f"{a} {b} {c} {d} 0" for a, b, c, d in (tets + 1).tolist()]
    return "\n".join([*lines, "End", ""])
