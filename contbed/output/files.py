"""Files that are either complete or not there."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile

from contbed.errors import ContbedError

_REMEDY = {
    errno.ENOSPC: "free some space or write elsewhere",
    errno.EDQUOT: "free some space or write elsewhere",
    errno.EACCES: "check the permissions or write elsewhere",
    errno.EROFS: "write elsewhere",
    errno.EISDIR: "a folder has this name; move it or write elsewhere",
    errno.ENOTDIR: "a file has the name of the folder; move it or write elsewhere",
    errno.EEXIST: "a file has the name of the folder; move it or write elsewhere",
}


@contextmanager
def atomic(path: Path | str) -> Iterator[Path]:
    """A file beside `path` to write to, which takes the name `path` when the block ends well.

    Until then an older `path` stays as it is, also when the process is killed. Missing folders are made.

    Raises
    ------
    ContbedError : one line, when the system cannot write
    """
    path = Path(path)
    temporary = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        _flush(temporary)
        os.replace(temporary, path)
        _flush(path.parent)
    except OSError as error:
        raise _cannot_write(path, error) from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def prepare(folder: Path) -> None:
    """Make a folder and try to write into it, so that no work is done in vain.

    Raises
    ------
    ContbedError : one line, when the system cannot write
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise _cannot_write(folder, error) from error


def _cannot_write(path: Path, error: OSError) -> ContbedError:
    remedy = _REMEDY.get(error.errno or 0)
    return ContbedError(f"cannot write {path}: {error.strerror or error}" + (f"; {remedy}" if remedy else ""))


def _flush(path: Path) -> None:
    """Wait until the disk holds a file, or the names in a folder."""
    if os.name == "nt" and path.is_dir():
        return
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
