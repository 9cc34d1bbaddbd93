"""Files that other files of a scene name: a geometry of gmsh those that it includes or
merges, a mechanism those whose species or reactions it takes.

Names that a geometry computes are not known before it is run.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from contbed.scene.mechanism import MECHANISM, mechanism_folders
from contbed.scene.stamp import Stamp, stamp_of

GEOMETRY = ".geo"
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_OPENED = re.compile(r"\b(?:Include|Merge|ShapeFromFile\s*\()\s*\"([^\"\n]+)\"")
_TAKEN = re.compile(r"([^\s\[\]{},:\"']+\.ya?ml)/\w")


def included(file: Path) -> Iterator[Path]:
    """Yield the files that a file names, and those that these name, each once; missing
    ones and what Cantera's own files name are left out.
    """
    known, found = {file.resolve()}, [file]
    for each in found:
        for other in _named_in(each):
            if other.resolve() not in known:
                known.add(other.resolve())
                found.append(other)
                yield other


def _named_in(file: Path) -> tuple[Path, ...]:
    folder, suffix = file.parent, file.suffix.lower()
    if suffix == GEOMETRY:
        names, folders = _names(file, stamp_of(file)), [folder]
    elif suffix in MECHANISM and not _is_of_cantera(file):
        names, folders = _names(file, stamp_of(file)), mechanism_folders(folder)
    else:
        return ()
    places = [[each / name for each in folders] for name in names]
    there = [[each for each in some if each.is_file()] for some in places]
    return tuple(some[0] for some in there if some)


def _is_of_cantera(file: Path) -> bool:
    folders = mechanism_folders(file.parent)[2:]
    return any(file.resolve().is_relative_to(each.resolve()) for each in folders)


@lru_cache(maxsize=64)
def _names(file: Path, stamp: Stamp) -> tuple[str, ...]:
    """Return the names in a file, which is read again only when it has changed."""
    text = file.read_text(encoding="utf-8", errors="replace")
    if file.suffix.lower() != GEOMETRY:
        return tuple(dict.fromkeys(_TAKEN.findall(text)))
    return tuple(dict.fromkeys(_OPENED.findall(_COMMENT.sub("", text))))
