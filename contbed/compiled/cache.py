"""Where numba keeps compiled code: in the folder for caches of the user, or elsewhere.

A home folder that cannot be written, as in many containers, would stop numba.
"""

from __future__ import annotations

import os
import stat
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any
from zlib import crc32

VARIABLE = "NUMBA_CACHE_DIR"
ROOMS = ("compiled", "solvers", "dem", "cfd_dem", "two_fluid")  # with kernels
# bytes of compiled code of all layouts of the package; one has 40 MB
LIMIT = 300e6
TUPLE = b"(NamedTuple):"
DAY = 86400.0  # s; an empty folder that is younger may belong to a run that compiles
COMPILING = (
    "contbed: compiling for this processor, once for an installation and up to a "
    "minute; `contbed warm` does it "
    "beforehand"
)


def choose_cache() -> None:
    """Name the folder for numba: that for caches of the user, else a temporary one.

    Each layout of the package has a folder of its own, as compiled code names modules
    and tuples: what was compiled before one of them moved cannot be read after it.
    """
    if VARIABLE in os.environ or "numba" in sys.modules:
        return
    home = _cache_of_the_user()
    if home is not None:
        folder = home / "contbed" / _layout()
        if _can_write(folder):
            os.environ[VARIABLE] = str(folder)
            if not folder.is_dir():
                remove_oldest(folder.parent)
            return
    import tempfile  # takes longer to import than all of this

    folder = (
        Path(tempfile.gettempdir())
        / f"contbed-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
    )
    try:
        folder.mkdir(mode=0o700)
        made = True
    except OSError:
        made = False
    if not _is_mine(folder):  # code of others must not run
        folder, made = Path(tempfile.mkdtemp(prefix="contbed-")), True
    os.environ[VARIABLE] = str(folder)
    if made:
        print(
            f"contbed: compiled code is kept in {folder}, as {home or 'a home folder'} "
            f"cannot be written; {VARIABLE} names another folder",
            file=sys.stderr,
        )


def remove_oldest(root: Path, limit: float = LIMIT, age: float = DAY) -> int:
    """Remove the oldest files below a folder until no more than a limit [bytes] is
    left, and empty folders of at least an age [s]; return the bytes removed.

    Runs that need a file which another process has removed compile it again.
    """
    files, folders = [], []
    for folder, _, names in os.walk(root, topdown=False):
        folders.append(folder)
        for name in names:
            path = os.path.join(folder, name)
            with suppress(OSError):
                status = os.stat(path)
                files.append((status.st_mtime, status.st_size, path))
    total = left = sum(size for _, size, _ in files)
    for _, size, path in sorted(files):
        if left <= limit:
            break
        with suppress(OSError):
            os.remove(path)
        left -= size
    for folder in folders:
        with suppress(OSError):
            if time.time() - os.stat(folder).st_mtime >= age:
                os.rmdir(folder)  # not if it holds something
    return total - left


def clear() -> tuple[Path, int]:
    """Remove all compiled code; return its folder and the bytes removed.

    Raises
    ------
    ContbedError : the folder is named by the user, and may hold code of others
    """
    from contbed.errors import ContbedError

    named = Path(os.environ[VARIABLE])
    home = _cache_of_the_user()
    if home is not None and named.parent == home / "contbed":
        folder = named.parent
    elif named.name.startswith("contbed-"):
        folder = named
    else:
        raise ContbedError(
            f"compiled code lies in {named}, which {VARIABLE} names; remove it there"
        )
    return folder, remove_oldest(folder, 0.0, 0.0)


def _layout() -> str:
    """Return a hash of the names of the modules in the rooms with kernels, and of the
    tuples that kernels take.
    """
    package = Path(__file__).parents[1]
    names = []
    for room in ROOMS:
        for folder, _, files in os.walk(package / room):
            for file in files:
                if file.endswith(".py"):
                    path = f"{folder}/{file}"
                    names.append(path.removeprefix(str(package)).encode())
                    names += _tuples(path)
    return f"{crc32(b' '.join(sorted(names))):08x}"


def _tuples(path: str) -> list[bytes]:
    """Return the first lines of the named tuples that a file defines."""
    with open(path, "rb") as file:
        text = file.read()
    if TUPLE not in text:
        return []
    return [line for line in text.splitlines() if line.endswith(TUPLE)]


def tell_when_compiling() -> None:
    """Say on stderr, once for a process, that kernels are compiled, as soon as the
    first one is.
    """
    from numba.core import event

    class Teller(event.Listener):
        told = False

        def on_start(self, event: Any) -> None:
            if not self.told:
                print(COMPILING, file=sys.stderr, flush=True)
            self.told = True

        def on_end(self, event: Any) -> None:
            """Nothing is said when a kernel is ready."""

    event.register("numba:compile", Teller())


def _cache_of_the_user() -> Path | None:
    """Return the folder for caches of this user; None for an account without a home
    folder.
    """
    if named := os.environ.get("XDG_CACHE_HOME"):
        return Path(named)
    try:
        return Path("~/.cache").expanduser()
    except RuntimeError:
        return None


def _can_write(folder: Path) -> bool:
    """Whether a folder, or the nearest one above it that exists, can be written."""
    try:
        there = next(path for path in (folder, *folder.parents) if path.exists())
        return there.is_dir() and os.access(there, os.W_OK | os.X_OK)
    except OSError:  # one of them may not be entered
        return False


def _is_mine(folder: Path) -> bool:
    try:
        status = folder.lstat()
    except OSError:
        return False
    mine = not hasattr(os, "getuid") or (
        status.st_uid == os.getuid() and not status.st_mode & 0o077
    )
    return stat.S_ISDIR(status.st_mode) and mine
