"""The wheel's build backend: maturin's, which on x86-64 builds the native half twice.

`chebloyd/_baseline` runs on every processor, `chebloyd/_v3` on those with AVX2, where it takes a fifth less
time; `chebloyd/_native.py` chooses at the first use. MATURIN_PEP517_ARGS="--profile dev" builds faster and
runs slower.
"""

from __future__ import annotations

import base64
import hashlib
import os
import platform
import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import maturin
from maturin import (  # noqa: F401  (the other hooks of PEP 517 and 660)
    build_editable,
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

BASELINE = "chebloyd/_baseline/_chebloyd"
V3 = "chebloyd/_v3/_chebloyd"
# The repository's own .cargo/config.toml says the same, so that this build shares its files.
V3_FLAGS = "-C target-cpu=x86-64-v3"


def build_wheel(wheel_directory: str, config_settings: Any = None, metadata_directory: Any = None) -> str:
    """Builds the wheel into a directory; returns its name."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return str(maturin.build_wheel(wheel_directory, config_settings, metadata_directory))
    with tempfile.TemporaryDirectory() as folder:
        with _environment(RUSTFLAGS=_flags(V3_FLAGS)):
            fast = Path(folder, maturin.build_wheel(folder, config_settings, metadata_directory))
        target = os.environ.get("CARGO_TARGET_DIR", str(Path(__file__).parent.parent / "target"))
        baseline = {"RUSTFLAGS": _flags(""), "CARGO_TARGET_DIR": str(Path(target, "baseline"))}
        if "--profile dev" in os.environ.get("MATURIN_PEP517_ARGS", ""):
            # A build for tests: this half shares no files with other builds and is to be ready soon.
            baseline["CARGO_PROFILE_DEV_OPT_LEVEL"] = "0"
        with _environment(**baseline):
            name = str(maturin.build_wheel(wheel_directory, config_settings, metadata_directory))
        _add(Path(wheel_directory, name), fast)
    return name


def _flags(own: str) -> str:
    return " ".join(filter(None, (os.environ.get("RUSTFLAGS", ""), own)))


@contextmanager
def _environment(**variables: str) -> Iterator[None]:
    before = dict(os.environ)
    os.environ.update(variables)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)


def _add(wheel: Path, fast: Path) -> None:
    """Puts the native half of the wheel `fast` beside that of `wheel`, and both into its RECORD."""
    with zipfile.ZipFile(fast) as source:
        names = [name for name in source.namelist() if name.startswith(BASELINE)]
        (module,) = (name for name in names if name.endswith((".so", ".pyd")))
        content = source.read(module)
    added = module.replace(BASELINE, V3)
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
    with zipfile.ZipFile(wheel) as old:
        entries = [(info, old.read(info)) for info in old.infolist()]
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as new:
        for info, data in entries:
            if info.filename.endswith(".dist-info/RECORD"):
                new.writestr(added, content)
                data = f"{added},sha256={digest},{len(content)}\n".encode() + data
            new.writestr(info, data, zipfile.ZIP_DEFLATED)
