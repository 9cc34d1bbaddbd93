"""Stamps of files: what has been read from a file is kept until its stamp is another."""

from __future__ import annotations

from pathlib import Path

Stamp = tuple[int, int, int]


def stamp_of(path: Path) -> Stamp:
    """Return inode, time of the last change [ns] and size [bytes] of a file.

    Raises
    ------
    OSError : there is none
    """
    status = path.stat()
    return status.st_ino, status.st_mtime_ns, status.st_size
