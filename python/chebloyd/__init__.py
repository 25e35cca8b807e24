"""Voronoi cells that become near-cubic, exact cells as arrays, and mass properties of solids.

    import numpy, chebloyd
    result = chebloyd.relax(numpy.random.default_rng(1).random((1000, 3)), iterations=50)
    print(result.frame()[["iteration", "energy_percent", "movement_percent"]].tail())

``relax``, ``measure``, ``energy`` and ``cells`` take arrays; ``scene`` runs a scene's file or dict; the other
functions are the program's commands under their own names. ``Box``, ``HalfSpaces``, ``Polygon``, ``Surface``
and ``Tets`` are domains, ``Lloyd``, ``QuasiNewton`` and ``Anneal`` methods. ``CPU`` says which native half
runs: "v3" (with AVX2) or "baseline".
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._cells import Cells, cells
    from ._commands import (
        Report,
        bench,
        command,
        fragments,
        integrate,
        mass,
        mesh,
        octree,
        plot,
        print as print,  # not in __all__: `import *` must leave Python's own
        report,
        schema,
        spin,
        stand,
    )
    from ._native import CPU
    from ._relax import Result, energy, measure, relax, scene
    from ._scene import Anneal, Box, HalfSpaces, Lloyd, Polygon, QuasiNewton, Surface, Tets

# Loaded when first asked for: `import chebloyd` takes hundredths of a second, without NumPy and the native half
# (https://scientific-python.org/specs/spec-0001).
_PLACES = {
    "_cells": "Cells cells",
    "_commands": "Report bench command fragments integrate mass mesh octree plot print report schema spin stand",
    "_native": "CPU",
    "_relax": "Result energy measure relax scene",
    "_scene": "Anneal Box HalfSpaces Lloyd Polygon QuasiNewton Surface Tets",
}


def __getattr__(name: str) -> object:
    for module, names in _PLACES.items():
        if name in names.split():
            value: object = getattr(import_module(f".{module}", __name__), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *(name for names in _PLACES.values() for name in names.split())})


__all__ = [
    "CPU",
    "Anneal",
    "Box",
    "Cells",
    "HalfSpaces",
    "Lloyd",
    "Polygon",
    "QuasiNewton",
    "Report",
    "Result",
    "Surface",
    "Tets",
    "bench",
    "cells",
    "command",
    "energy",
    "fragments",
    "integrate",
    "mass",
    "measure",
    "mesh",
    "octree",
    "plot",
    "relax",
    "report",
    "scene",
    "schema",
    "spin",
    "stand",
]
