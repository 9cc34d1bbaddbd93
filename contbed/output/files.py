"""Files that are either complete or absent."""

from __future__ import annotations

import errno
import os
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile

from contbed.errors import ContbedError

TOKEN = 8  # random bytes in the name of a file that is being written
# of folders that a run holds: called with the name of each file
watchers: dict[Path, Callable[[str], None]] = {}

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
    """Yield a new file beside `path` to write to, which takes the name `path` when the
    block ends without an error.

    Until then an older `path` stays as it is, also when the process is killed. Missing
    folders are made. The name of the new file cannot be foreseen, and a link of that
    name would not be followed.

    Raises
    ------
    ContbedError : one line, when the system cannot write
    """
    path = Path(path)
    temporary = path.with_name(f"{path.name}.{secrets.token_hex(TOKEN)}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        watch = watchers.get(path.parent.resolve()) if watchers else None
        if watch is not None:
            watch(path.name)
        os.close(
            os.open(
                temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666
            )
        )
        yield temporary
        _flush(temporary)
        os.replace(temporary, path)
        _flush(path.parent)
    except OSError as error:
        raise _cannot_write(path, error) from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def write_text(path: Path | str, text: str) -> None:
    """Write a text, whole or not at all."""
    with atomic(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


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
    return ContbedError(
        f"cannot write {path}: {error.strerror or error}"
        + (f"; {remedy}" if remedy else "")
    )


def _flush(path: Path) -> None:
    """Wait until the disk holds a file, or the names in a folder."""
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
