"""The native half that this processor runs fastest: chosen at the package's first use.

The environment variable CHEBLOYD_CPU forces a choice: ``baseline`` runs everywhere, ``v3`` needs AVX2.
Results are the same to the last bit.
"""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from ._baseline import _chebloyd as native
    from ._baseline._chebloyd import is_v3
else:

    def _choose():
        baseline = importlib.import_module("chebloyd._baseline._chebloyd")
        wanted = os.environ.get("CHEBLOYD_CPU", "auto")
        if wanted not in ("auto", "baseline", "v3"):
            raise ImportError(f"CHEBLOYD_CPU is {wanted!r}; it can be auto, baseline or v3")
        if wanted == "baseline" or wanted == "auto" and not baseline.has_v3():
            return baseline
        if not baseline.has_v3():
            raise ImportError("CHEBLOYD_CPU is 'v3', and this processor has no AVX2; say baseline")
        try:
            return importlib.import_module("chebloyd._v3._chebloyd")
        except ModuleNotFoundError:
            # A build for development has one native half only.
            if wanted == "v3" and not baseline.is_v3():
                raise
            return baseline

    native = _choose()
    is_v3 = native.is_v3

CPU: Literal["v3", "baseline"] = "v3" if is_v3() else "baseline"

__all__ = ["CPU", "native"]
