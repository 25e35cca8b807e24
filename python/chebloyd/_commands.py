"""The program's commands as functions: files or arrays in, the object that ``--json`` prints out.

Options have the program's names with underscores: ``feature_angle=40`` is ``--feature-angle=40``, ``True`` a
flag, numbers in a sequence are joined by commas, several texts repeat the option. What is misspelt or out of
range is refused as on the command line.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ._meshes import Files, Mesh
from ._native import native

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class Report(dict[str, Any]):
    """The object that a command prints with ``--json``; its keys are attributes too."""

    #: What there is to say about the input, one sentence each.
    notes: list[str]
    #: The sentence of exit code 1 where the report is whole all the same: infeasible, or a limit passed.
    failure: str | None

    def __init__(
        self, items: Mapping[str, Any], *, notes: Sequence[str] = (), failure: str | None = None
    ) -> None:
        super().__init__(items)
        self.__dict__["notes"] = list(notes)
        self.__dict__["failure"] = failure

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"the report has no {name!r}; it has {', '.join(self)}") from None


def command(
    name: str,
    *arguments: str | os.PathLike[str],
    threads: int | None = None,
    is_patient: bool = False,
    **options: Any,
) -> Report:
    """Runs a command of the program: ``command("mass", "part.stl", density="1 + x")``.

    Ctrl-C raises at once, and the command's threads go on to their end; if it ``is_patient`` it is asked to
    end first, and a second Ctrl-C raises at once. A command without ``--json`` leaves ``"text"``.
    """
    with Files() as files:
        words = [name, *(os.fspath(word) for word in arguments)]
        for key, value in options.items():
            words += _option(key.strip("_").replace("_", "-"), value, files)
        if name in _WITH_JSON:
            words.append("--json")
        if name in _TALKATIVE:
            words.append("--quiet")
        output, notes, failure = native.call(words, threads, is_patient)
    text = output.decode()
    if name in _WITH_JSON or name == "schema":
        return Report(json.loads(text), notes=notes, failure=failure)
    return Report({"text": text}, notes=notes, failure=failure)


_WITH_JSON = {"relax", "mass", "integrate", "mesh", "spin", "stand", "octree", "report", "print"}
_TALKATIVE = {"relax", "mesh"}


def _option(name: str, value: Any, files: Files) -> list[str]:
    """An option as the program reads it."""
    if value is None or value is False:
        return []
    if value is True:
        return [f"--{name}"]
    if isinstance(value, (str, os.PathLike)):
        return [f"--{name}={os.fspath(value)}"]
    if isinstance(value, Mapping):
        if name == "density":
            return [f"--{name}={files.field(dict(value))}"]
        return [f"--{name}={key}={_word(item)}" for key, item in value.items()]
    if isinstance(value, Iterable):
        items = list(np.asarray(value).ravel()) if isinstance(value, np.ndarray) else list(value)
        if items and all(isinstance(item, (str, os.PathLike)) for item in items):
            return [f"--{name}={os.fspath(item)}" for item in items]
        return [f"--{name}={','.join(map(_word, items))}"]
    return [f"--{name}={_word(value)}"]


def _word(value: Any) -> str:
    """A number as the program reads it; None is a coordinate that is free."""
    if value is None:
        return "_"
    if isinstance(value, (bool, str)):
        return str(value)
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    number = float(value)
    if math.isinf(number):
        return "inf" if number > 0 else "-inf"
    return repr(number)


def _of_meshes(name: str, meshes: Sequence[Mesh], threads: int | None, options: Mapping[str, Any]) -> Report:
    with Files() as files:
        return command(name, *(files.mesh(mesh) for mesh in meshes), threads=threads, **options)


def mass(*solids: Mesh, threads: int | None = None, **options: Any) -> Report:
    """Mass properties of solids, or of a print (.gcode): ``chebloyd mass SOLID…``.

    Keys: ``volume`` (L³), ``surface_area`` (L²), ``mass``, ``center_of_mass`` [3] (L), ``inertia_origin`` and
    ``inertia_center`` [3][3] (mass · L²; off-diagonals are negative products), ``principal_moments`` [3],
    ``principal_axes`` [3][3]. Options: ``density`` (formula, number or field's dict), ``units``, ``si``, …
    """
    return _of_meshes("mass", solids, threads, options)


def integrate(solid: Mesh, *, threads: int | None = None, **options: Any) -> Report:
    """Integrals of polynomials over a surface and its solid: ``chebloyd integrate FILE``.

    Keys: ``surface`` and ``volume``, each exponents ``"a,b,c"`` → value; ``mirtich``, ``first_moments``,
    ``second_moments``, ``products_of_inertia``, ``faces``. Options: ``monomials`` (degree), ``of`` (a
    polynomial), ``signed`` (x, y, z).
    """
    return _of_meshes("integrate", [solid], threads, options)


def stand(*solids: Mesh, threads: int | None = None, **options: Any) -> Report:
    """Densities with which solids stand: ``chebloyd stand SOLID…``.

    Keys: ``stands``, ``feasible``, ``least_contrast``, ``mass``, ``center_of_mass`` [3], ``slack``,
    ``tilt_degrees``, … Options: ``range`` (lo, hi), ``point`` (x, y), ``target`` (x, y, z; None is free),
    ``goal``, ``out``, … Where it is infeasible, ``.failure`` says why.
    """
    return _of_meshes("stand", solids, threads, options)


def spin(*solids: Mesh, threads: int | None = None, **options: Any) -> Report:
    """Densities with which solids spin about an axis: ``chebloyd spin SOLID… --axis …``.

    Keys: ``feasible``, ``distance`` (L), ``angle_degrees``, ``mass``, ``center_of_mass`` [3],
    ``inertia_center`` [3][3]. Options: ``axis`` (px, py, pz, dx, dy, dz), ``range``, ``basis``, ``out``, …
    """
    return _of_meshes("spin", solids, threads, options)


def octree(*models: Mesh, threads: int | None = None, **options: Any) -> Report:
    """Octrees of solids, and how far their moments are off: ``chebloyd octree MODEL…``."""
    return _of_meshes("octree", models, threads, options)


def mesh(
    source: Mesh | None = None,
    output: str | os.PathLike[str] | None = None,
    *,
    threads: int | None = None,
    **options: Any,
) -> Report:
    """Writes the cells of a run as one mesh: ``chebloyd mesh RUN_DIR -o OUTPUT``; or ``check=PATH`` measures one.

    Options: ``to`` ("polymesh", "vtu", …), ``feature_angle`` (degrees), ``collapse``, ``limit``
    ({"nonorth": 70, "skew": 4}), ``scale``, ``force``. Keys: ``points``, ``faces``, ``cells``, ``patches``,
    ``volume`` (L³), ``non_orthogonality_max`` (degrees), ``skewness_max``, … Where a limit is passed,
    ``.failure`` says which.
    """
    given = [] if source is None else [source]
    return _of_meshes("mesh", given, threads, {"output": output, **options})


def report(
    *runs: str | os.PathLike[str],
    output: str | os.PathLike[str] = "report.html",
    threads: int | None = None,
    **options: Any,
) -> Report:
    """Writes one offline page about runs: ``chebloyd report RUN_DIR… -o report.html``."""
    return command("report", *runs, threads=threads, output=output, **options)


def plot(
    *logs: str | os.PathLike[str] | Sequence[Mapping[str, Any]],
    output: str | os.PathLike[str] = "convergence.svg",
    threads: int | None = None,
    **options: Any,
) -> Report:
    """Draws energy and movement of logs, files or ``Result.log``: ``chebloyd plot LOG… -o FILE.svg``."""
    with Files() as files:
        words = [_log(log, files) for log in logs]
        return command("plot", *words, threads=threads, output=output, **options)


def _log(log: str | os.PathLike[str] | Sequence[Mapping[str, Any]], files: Files) -> str:
    if isinstance(log, (str, os.PathLike)):
        return os.fspath(log)
    path = files.path("log.jsonl")
    path.write_text("".join(json.dumps(dict(record)) + "\n" for record in log))
    return str(path)


def print(
    source: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    threads: int | None = None,
    **options: Any,
) -> Report:
    """Writes a print whose infill follows a density: ``chebloyd print IN.gcode -o OUT.gcode``.

    ``density`` (a field), or ``stand=True`` or ``spin=True`` with those commands' options. Keys: wanted and
    obtained moments of the written file (mm, mm³).
    """
    return command("print", source, threads=threads, output=output, **options)


def fragments(
    scene: str | os.PathLike[str] | Mapping[str, Any],
    output: str | os.PathLike[str],
    *,
    sites: ArrayLike | None = None,
    threads: int | None = None,
    **options: Any,
) -> Report:
    """Draws the six fragments of a cell: ``chebloyd fragments SCENE.json -o FILE``; ``site=I`` or ``all=True``."""
    with Files() as files:
        path = scene
        if isinstance(scene, Mapping):
            path = files.path("scene.json")
            path.write_text(json.dumps(scene))
        if sites is not None:
            options["sites"] = files.points(sites, "sites.npy")
        return command("fragments", os.fspath(str(path)), threads=threads, output=output, **options)


def schema(*, field: bool = False) -> Report:
    """The JSON Schema of scenes, or of field files."""
    return command("schema", field=field)


def bench(*, threads: int | None = None, **options: Any) -> Report:
    """Times the program's stages: ``chebloyd bench``; the table is in ``["text"]``."""
    return command("bench", threads=threads, **options)
