"""Domains and methods as small classes; scenes as the program's JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from ._meshes import Files, Mesh
from ._native import native

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

Sites: TypeAlias = "NDArray[np.float64]"


@dataclass(frozen=True)
class Box:
    """The box between two corners, periodic along all axes, none, or those whose entry is true.

    Corners of two numbers make a rectangle of the plane. Lengths are in the unit of the sites (L).
    """

    min: Sequence[float] = (0.0, 0.0, 0.0)
    max: Sequence[float] = (1.0, 1.0, 1.0)
    periodic: bool | Sequence[bool] = False

    def key(self, files: Files) -> dict[str, Any]:
        """The scene's ``domain``."""
        periodic = self.periodic
        along = [periodic] * len(self.min) if isinstance(periodic, bool) else [bool(p) for p in periodic]
        low, high = ([float(x) for x in corner] for corner in (self.min, self.max))
        return {"box": {"min": low, "max": high, "periodic": along}}


@dataclass(frozen=True)
class HalfSpaces:
    """The points y with n·y ≤ d for every row (n, d): shape (m, 4), in the plane (m, 3)."""

    rows: ArrayLike

    def key(self, files: Files) -> dict[str, Any]:
        """The scene's ``domain``."""
        return {"half_spaces": np.asarray(self.rows, dtype=np.float64).tolist()}


@dataclass(frozen=True)
class Polygon:
    """A polygon of the plane: its corners (n, 2) in order, or a list of such loops, holes among them."""

    loops: Any

    def key(self, files: Files) -> dict[str, Any]:
        """The scene's ``domain``."""
        try:
            return {"polygon": np.asarray(self.loops, dtype=np.float64).tolist()}
        except ValueError:
            return {"polygon": [np.asarray(loop, dtype=np.float64).tolist() for loop in self.loops]}


@dataclass(frozen=True)
class Surface:
    """The solid within a closed surface: a file, ``(vertices, triangles)``, or trimesh's or PyVista's mesh.

    ``scale_to`` fits it into ``"unit_cube"``, a cube's side (L) or ``{"min": …, "max": …}``; ``weld`` merges
    vertices of an open mesh up to so far apart (L).
    """

    mesh: Mesh
    scale_to: str | float | dict[str, Any] | None = None
    weld: float | None = None

    def key(self, files: Files) -> dict[str, Any]:
        """The scene's ``domain``."""
        return _mesh_key("surface", self, files)


@dataclass(frozen=True)
class Tets:
    """The solid that tetrahedra fill: a file or ``(vertices (n, 3), tetrahedra (m, 4))``. See ``Surface``."""

    mesh: Mesh
    scale_to: str | float | dict[str, Any] | None = None
    weld: float | None = None

    def key(self, files: Files) -> dict[str, Any]:
        """The scene's ``domain``."""
        return _mesh_key("tets", self, files)


def _mesh_key(kind: str, domain: Surface | Tets, files: Files) -> dict[str, Any]:
    key: dict[str, Any] = {kind: os.path.abspath(files.mesh(domain.mesh))}
    options = {"scale_to": domain.scale_to, "weld": domain.weld}
    return key | {name: value for name, value in options.items() if value is not None}


Domain: TypeAlias = "Box | HalfSpaces | Polygon | Surface | Tets | Mapping[str, Any] | Any"


@dataclass(frozen=True)
class _Method:
    def key(self) -> dict[str, Any]:
        """The scene's ``method``."""
        options = {field.name: getattr(self, field.name) for field in fields(self)}
        given = {name: value for name, value in options.items() if value is not None}
        return {_METHODS[type(self)]: given}


@dataclass(frozen=True)
class Lloyd(_Method):
    """Every site moves to its cell's center, again and again (50 times unless told otherwise).

    ``tolerance`` ends the run below so many percent of movement; ``accelerate`` goes three times as far where
    that ends lower. Left out, options have the program's defaults.
    """

    iterations: int | None = None
    tolerance: float | None = None
    accelerate: bool | None = None


@dataclass(frozen=True)
class QuasiNewton(_Method):
    """All sites descend together along the exact global objective (L-BFGS-B)."""

    iterations: int | None = None
    tolerance: float | None = None
    warm_up: int | None = None
    memory: int | None = None
    gradient_tolerance: float | None = None


@dataclass(frozen=True)
class Anneal(_Method):
    """Descents from noise that falls round by round; the best sites are kept."""

    iterations: int | None = None
    tolerance: float | None = None
    rounds: int | None = None
    steps: int | None = None
    noise: float | None = None
    fall: float | None = None
    seed: int | None = None
    first_steps: int | None = None
    memory: int | None = None
    gradient_tolerance: float | None = None
    warm_up: int | None = None
    exchange: bool | None = None


_METHODS: dict[type[_Method], str] = {Lloyd: "lloyd", QuasiNewton: "quasi_newton", Anneal: "anneal"}

Method: TypeAlias = 'Literal["lloyd", "quasi_newton", "anneal"] | Lloyd | QuasiNewton | Anneal | Mapping[str, Any] | str'


def points_of(sites: ArrayLike) -> Sites:
    """Sites as an (n, 3) or (n, 2) array of float64; one that is such already is not copied."""
    points = np.asarray(sites, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise ValueError(f"sites have shape {points.shape}; (n, 3) is needed, in the plane (n, 2)")
    return points


def domain_key(domain: Domain, dimension: int, files: Files) -> dict[str, Any] | None:
    """The scene's ``domain``; none is the unit cube, in the plane the unit square."""
    if domain is None:
        return None
    if isinstance(domain, (Box, HalfSpaces, Polygon, Surface, Tets)):
        return domain.key(files)
    if isinstance(domain, Mapping):
        return {name: _plain(value, files, name) for name, value in domain.items()}
    if all(hasattr(domain, name) for name in ("L", "xy", "xz", "yz", "periodic")):
        return _freud_box(domain, dimension).key(files)
    if not isinstance(domain, (str, os.PathLike)) and np.shape(domain) == (dimension, dimension):
        raise ValueError(
            "a domain given by lattice vectors is triclinic, and periodic boxes here have axes along x, y and z; "
            "give a Box"
        )
    raise ValueError(
        f"a domain is a Box, HalfSpaces, Polygon, Surface, Tets or a dict such as {{'box': …}}; not {domain!r}"
    )


def _plain(value: Any, files: Files, name: str) -> Any:
    if name in ("surface", "tets"):
        return os.path.abspath(files.mesh(value))
    return value.tolist() if isinstance(value, np.ndarray) else value


def _freud_box(box: Any, dimension: int) -> Box:
    if any(getattr(box, tilt) != 0 for tilt in ("xy", "xz", "yz")):
        raise ValueError(
            f"the box is triclinic (xy {box.xy}, xz {box.xz}, yz {box.yz}), and periodic boxes here have axes "
            "along x, y and z"
        )
    sides = [float(x) for x in np.asarray(box.L, dtype=np.float64)[:dimension]]
    periodic = [bool(p) for p in box.periodic[:dimension]]
    return Box([-x / 2 for x in sides], [x / 2 for x in sides], periodic)


def scene_text(
    dimension: int,
    domain: Domain,
    files: Files,
    keys: Mapping[str, Any],
) -> str:
    """A scene without ``sites`` as JSON; keys that are None are left out."""
    scene: dict[str, Any] = {"dimension": dimension}
    scene["domain"] = domain_key(domain, dimension, files)
    scene.update(keys)
    return json.dumps({name: value for name, value in scene.items() if value is not None}, default=_number)


def _number(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{value!r} has no place in a scene")


def method_key(
    method: Method | None, goal: str | None, options: Mapping[str, Any]
) -> dict[str, Any] | None:
    """The scene's ``method``, with options that replace or add to its own."""
    given = {name: value for name, value in options.items() if value is not None}
    if goal is not None:
        if goal not in ("cubes", "squares"):
            raise ValueError(f"the goal is {goal!r}; it can be 'cubes', in the plane 'squares'")
        if method is not None:
            raise ValueError("a goal chooses the method; leave one of them out")
        method = json.loads(native.cubes())
    if method is None:
        method = "lloyd"
    if isinstance(method, _Method):
        key = method.key()
    elif isinstance(method, str):
        key = {method.replace("-", "_"): {}}
    else:
        key = {name: dict(value) for name, value in method.items()}
    for of_method in key.values():
        of_method.update(given)
    return key


def density_key(density: str | float | Mapping[str, Any] | None, files: Files) -> Any:
    """The scene's ``density``: a formula, a number, ``{"size": …}`` or a field file's dict."""
    if density is None or isinstance(density, str):
        return density
    if isinstance(density, Mapping):
        is_key = set(density) <= {"polynomial", "data", "size"}
        return dict(density) if is_key else files.field(dict(density))
    return repr(float(density))


def frames_key(frames: Any, files: Files) -> Any:
    """The scene's ``frames``: "boundary", one turn as a dict, or rotation vectors (n, 3) in radians."""
    if frames is None or isinstance(frames, (str, Mapping)):
        return frames
    return {"file": files.points(frames, "frames.npy")}
