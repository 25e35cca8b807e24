"""Relaxations, figures and energies of given sites."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ._commands import Report, command
from ._meshes import Files
from ._native import native
from ._scene import (
    Domain,
    Method,
    Sites,
    density_key,
    frames_key,
    method_key,
    points_of,
    scene_text,
)

if TYPE_CHECKING:
    import pandas
    from numpy.typing import ArrayLike, NDArray

#: Called with every record and its sites (n, 3); ``False`` ends the run.
Callback = Callable[[dict[str, Any], Sites], "bool | None"]


@dataclass(frozen=True)
class Result:
    """What a relaxation leaves."""

    #: The sites (n, 3), in the plane (n, 2), in the order of those given (L).
    sites: Sites
    #: One dict per record, the first before any move: the keys of ``log.jsonl``.
    log: list[dict[str, Any]]
    #: Why it ended: ``"iterations"``, ``"tolerance"`` or ``"callback"``.
    ended: str
    #: What was repaired in the domain's mesh, one sentence each.
    notes: list[str] = field(default_factory=list)

    def frame(self) -> pandas.DataFrame:
        """The log as a pandas table, a row per record."""
        import pandas

        return pandas.DataFrame(self.log)

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Writes ``sites.csv`` and ``log.jsonl`` as ``chebloyd relax`` does, into a folder that has neither."""
        target = Path(folder)
        target.mkdir(parents=True, exist_ok=True)
        with open(target / "sites.csv", "x") as file:
            file.write(",".join("xyz"[: self.sites.shape[1]]) + "\n")
            file.writelines(",".join(map(_shortest, row)) + "\n" for row in self.sites.tolist())
        with open(target / "log.jsonl", "x") as file:
            file.writelines(json.dumps(record) + "\n" for record in self.log)


def _shortest(number: float) -> str:
    """The shortest decimal that reads back to the same number, as the program writes it."""
    return repr(number).replace("e-0", "e-").replace("e+", "e")


def relax(
    sites: ArrayLike,
    *,
    domain: Domain = None,
    density: str | float | Mapping[str, Any] | None = None,
    norm: Literal["linf", "l2"] = "linf",
    cells: Literal["l2", "linf"] = "l2",
    order: int = 1,
    method: Method | None = None,
    goal: Literal["cubes", "squares"] | None = None,
    iterations: int | None = None,
    tolerance: float | None = None,
    coarse_to_fine: int | None = None,
    frames: ArrayLike | Mapping[str, Any] | Literal["boundary"] | None = None,
    drop_outside: bool = False,
    threads: int | None = None,
    callback: Callback | None = None,
    **options: Any,
) -> Result:
    """Moves sites until their Voronoi cells are near-cubic.

    ``sites`` are (n, 3), in the plane (n, 2); they are not changed. ``domain`` is the unit cube unless a
    ``Box``, ``HalfSpaces``, ``Polygon``, ``Surface``, ``Tets`` or a scene's dict is given. ``method`` is a
    name, ``Lloyd``, ``QuasiNewton`` or ``Anneal``, or a scene's dict; further keywords are its options.
    ``goal="cubes"`` chooses the method that makes cubes. ``density`` is a formula such as ``"1 + 2*x"``,
    ``{"size": "0.1 + x"}`` or a field's dict.

    ``callback(record, sites)`` is called after every move, its ``False`` ends the run. Ctrl-C raises at once.
    The same input gives the same bits for any number of threads, and those of ``chebloyd relax``. Raises
    ``ValueError`` and ``OSError`` with the program's sentences.
    """
    points = points_of(sites)
    with Files() as files:
        options = {"iterations": iterations, "tolerance": tolerance, **options}
        keys = {
            "density": density_key(density, files),
            "norm": norm,
            "cells": cells,
            "order": order,
            "method": method_key(method, goal, options),
            "coarse_to_fine": coarse_to_fine,
            "frames": frames_key(frames, files),
            "drop_outside": drop_outside,
        }
        text = scene_text(points.shape[1], domain, files, keys)
        return _run(text, points, threads, callback)


def _run(text: str, points: Sites | None, threads: int | None, callback: Callback | None) -> Result:
    call = None
    if callback is not None:
        hear = callback

        def call(line: str, at: Sites) -> bool | None:
            return hear(json.loads(line), at)

    relaxed, log, ended, notes = native.relax(text, points, threads, call)
    return Result(relaxed, [json.loads(line) for line in log], ended, notes)


def scene(
    scene: str | os.PathLike[str] | Mapping[str, Any],
    *,
    sites: ArrayLike | None = None,
    out: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
    **options: Any,
) -> Result | Report:
    """Runs a scene: a file or a dict, as ``chebloyd relax SCENE.json`` does.

    Without ``out`` nothing is written and a ``Result`` comes back. ``sites`` take the place of those that the
    scene names. With ``out`` the program's own run leaves all its files there (Ctrl-C completes them before it
    raises), ``options`` are those of ``chebloyd relax``, such as ``force=True``, and what ``run.json`` holds
    comes back.
    """
    with Files() as files:
        path = _scene_file(scene, files)
        if out is not None:
            if callback is not None:
                raise ValueError("a run with files has no callback; read its log.jsonl instead")
            options |= {"out": out, "sites": None if sites is None else files.points(sites, "sites.npy")}
            return command("relax", path, threads=threads, is_patient=True, **options)
        if options:
            raise ValueError(f"options such as {next(iter(options))} are for runs with `out`; change the scene")
        points = None if sites is None else points_of(sites)
        return _run(path, points, threads, callback)


def _scene_file(scene: str | os.PathLike[str] | Mapping[str, Any], files: Files) -> str:
    if not isinstance(scene, Mapping):
        return os.fspath(scene)
    path = files.path("scene.json")
    path.write_text(json.dumps(scene))
    return str(path)


def measure(
    sites: ArrayLike,
    *,
    domain: Domain = None,
    density: str | float | Mapping[str, Any] | None = None,
    norm: Literal["linf", "l2"] = "linf",
    cells: Literal["l2", "linf"] = "l2",
    order: int = 1,
    frames: ArrayLike | Mapping[str, Any] | Literal["boundary"] | None = None,
    drop_outside: bool = False,
    threads: int | None = None,
) -> Report:
    """The figures of the tessellation of ``sites`` (n, 3): the keys that ``chebloyd measure`` prints.

    ``"cells"`` holds arrays in site order: ``volume`` (n,) (L³), ``centroid`` (n, 3), ``energy`` (n,) and its
    ``gradient`` (n, 3) at the sites, ``center`` (n, 3), the minimizer, with ``center_energy`` (n,), and
    ``facets`` (n,).
    """
    points = points_of(sites)
    with Files() as files:
        keys = {
            "density": density_key(density, files),
            "norm": norm,
            "cells": cells,
            "order": order,
            "frames": frames_key(frames, files),
            "drop_outside": drop_outside,
        }
        text = scene_text(points.shape[1], domain, files, keys)
        figures, columns, dropped, notes = native.measure(text, points, threads)
    report = Report(json.loads(figures), notes=notes)
    if dropped:
        report["dropped_outside"] = dropped
    report["cells"] = columns
    return report


def energy(
    sites: ArrayLike,
    *,
    domain: Domain = None,
    density: str | float | Mapping[str, Any] | None = None,
    cells: Literal["l2", "linf"] = "l2",
    order: int = 1,
    threads: int | None = None,
) -> tuple[float, NDArray[np.float64]]:
    """The global objective Σ ∫ d∞(x_i, y)^p dy over the cells (L^(3+p)) and its exact gradient (n, 3).

    For optimizers of your own, such as SciPy's ``minimize(…, jac=True)``.
    """
    points = points_of(sites)
    with Files() as files:
        keys = {"density": density_key(density, files), "cells": cells, "order": order}
        return native.energy(scene_text(points.shape[1], domain, files, keys), points, threads)
