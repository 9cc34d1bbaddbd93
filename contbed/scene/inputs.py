"""Input files that a scene names: which they are, whether they can be read, and whether
reading them runs code.

No file is used before it has been checked here: pipes and devices, which may never end,
very large files and files that run programs are refused with the line of their key.
`Origin` says what the user has allowed.
"""

from __future__ import annotations

import gzip
import os
import stat
import zlib
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path
from typing import Any

from contbed.scene.included import GEOMETRY, included
from contbed.scene.mechanism import (
    aliases_that_multiply,
    code_in_mechanism,
    mechanism_file,
    mechanism_folders,
    other_format,
)
from contbed.scene.stamp import Stamp, stamp_of
from contbed.scene.toml_lines import KeyPath, Origin
from contbed.scene.values import tables

# bytes, unpacked, above which a file is only read with --allow-large
LARGE_FILE = 500_000_000
_PIECE = 1 << 20  # bytes
_TRUST = "refused unless you trust it: --trust, in Python load(..., trust=True)"
_ALLOW = "read only with --allow-large, in Python load(..., allow_large=True)"


def named_files(part: Any) -> Iterator[tuple[KeyPath, str]]:
    """Yield key and name of the files that a scene names: meshes, closures,
    particles, mechanisms.
    """
    for path, table in tables(part):
        for name in ("file", "mechanism"):
            value = getattr(table, name, None)
            named = name == "file" or (
                hasattr(table, "surface") or getattr(table, "composition", None)
            )
            if named and isinstance(value, str):
                yield (*path, name), value


def file_of(path: KeyPath, name: str, base: Path) -> Path | None:
    """Return the file that a key names; None if a mechanism is not found."""
    return mechanism_file(name, base) if path[-1] == "mechanism" else base / name


def inputs_by_key(part: Any, base: Path) -> Iterator[tuple[KeyPath, Path]]:
    """Yield key and path of all files that a scene names, and of those that they name;
    missing files are left out.
    """
    for path, name in (*named_files(part), *getattr(part, "_tables", ())):
        file = file_of(path, name, base)
        if file is None or "\0" in name or not file.is_file():
            continue
        yield path, file
        yield from ((path, other) for other in included(file))


def all_inputs(part: Any, base: Path) -> list[Path]:
    """Return all files that a run reads, each once; see `inputs_by_key`."""
    return list(dict.fromkeys(file for _, file in inputs_by_key(part, base)))


def inputs_elsewhere(part: Any, base: Path) -> list[Path]:
    """Return the files that a run reads outside of the folder of its scene; data of
    Cantera are none.
    """
    known = [base.resolve(), *(each.resolve() for each in mechanism_folders(base)[2:])]
    return [
        file
        for file in all_inputs(part, base)
        if not any(file.resolve().is_relative_to(folder) for folder in known)
    ]


def unusable_files(
    parts: Mapping[str, Any], origin: Origin
) -> Iterator[tuple[KeyPath, str]]:
    """Yield the keys whose file must not be read, and why.

    The checks of each physics report files that are missing.
    """
    for path, name in named_files(parts):
        if reason := why_unusable(path, name, origin):
            yield path, reason


def why_unusable(path: KeyPath, name: str, origin: Origin) -> str:
    """Return why the file that a key names must not be read; empty if it may, or is
    missing.
    """
    if "\0" in name:
        return ""
    file = file_of(path, name, origin.base)
    if file is None:
        folders = dict.fromkeys(
            folder.absolute() for folder in mechanism_folders(origin.base)
        )
        files = [each.name for folder in folders for each in folder.glob("*.yaml")]
        near = get_close_matches(name, files, n=1, cutoff=0.65)
        return f"no such mechanism; looked in {', '.join(map(str, folders))}" + (
            f"; did you mean '{near[0]}'?" if near else ""
        )
    try:
        status = file.stat()
    except OSError:
        return ""
    if not stat.S_ISREG(status.st_mode):
        return "is a folder, a pipe or a device; give a file"
    if not origin.allow_large and _size(file, status) > LARGE_FILE:
        packed = ", unpacked" if file.suffix == ".gz" else ""
        return f"is larger than {LARGE_FILE // 10**6} MB{packed}; {_ALLOW}"
    if path[-1] == "mechanism":
        found = (
            other_format(each) or aliases_that_multiply(each)
            for each in (file, *included(file))
        )
        if reason := next(filter(None, found), ""):
            return reason
    programs = "" if origin.trust else _code(path, file, origin.base)
    return f"{programs}; {_TRUST}" if programs else ""


def _size(file: Path, status: os.stat_result) -> int:
    """Return the size of a file [bytes], of a .gz what it unpacks to; count no
    further than to the limit.
    """
    if file.suffix != ".gz" or status.st_size > LARGE_FILE:
        return status.st_size
    return _unpacked_size(file, stamp_of(file))


@lru_cache(maxsize=64)
def _unpacked_size(file: Path, stamp: Stamp) -> int:
    total = 0
    try:
        with gzip.open(file) as stream:
            while total <= LARGE_FILE and (piece := stream.read(_PIECE)):
                total += len(piece)
    except (OSError, EOFError, zlib.error):
        return total  # whoever reads it says that it is damaged
    return total


def _code(path: KeyPath, file: Path, base: Path) -> str:
    """Return what a file would run when it is read; empty for nothing."""
    try:
        if path[-1] == "mechanism":
            inside = mechanism_folders(base)[-1]
            shipped = inside.name == "data" and file.resolve().is_relative_to(
                inside.resolve()
            )
            return "" if shipped else code_in_mechanism(file) or ""
        if file.suffix.lower() == GEOMETRY:
            return "a geometry of gmsh may run programs and write files"
    except OSError:
        return ""  # whoever reads it says so
    return ""
