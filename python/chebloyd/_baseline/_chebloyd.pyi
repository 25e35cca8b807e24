from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

def has_v3() -> bool: ...
def is_v3() -> bool: ...
def relax(
    scene: str,
    sites: NDArray[np.float64] | None = None,
    threads: int | None = None,
    callback: Callable[[str, NDArray[np.float64]], bool | None] | None = None,
) -> tuple[NDArray[np.float64], list[str], str, list[str]]: ...
def measure(
    scene: str, sites: NDArray[np.float64] | None = None, threads: int | None = None
) -> tuple[str, dict[str, NDArray[Any]], int, list[str]]: ...
def energy(
    scene: str, sites: NDArray[np.float64] | None = None, threads: int | None = None
) -> tuple[float, NDArray[np.float64]]: ...
def cells(
    scene: str,
    sites: NDArray[np.float64],
    select: NDArray[np.int64] | None = None,
    known: Sequence[Sequence[float]] | None = None,
    shapes: bool = True,
    threads: int | None = None,
) -> tuple[dict[str, NDArray[Any]], list[str]]: ...
def call(
    arguments: Sequence[str], threads: int | None = None, is_patient: bool = False
) -> tuple[bytes, list[str], str | None]: ...
def program(arguments: Sequence[str]) -> int: ...
def cubes() -> str: ...
