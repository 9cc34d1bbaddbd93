"""Where numba keeps compiled code: beside the modules or in the home folder, which are its defaults, or elsewhere.

An installation that cannot be written and a home folder that cannot either, as in many containers, would stop numba.
"""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path
from typing import Any

VARIABLE = "NUMBA_CACHE_DIR"
COMPILING = (
    "contbed: compiling for this processor, once for an installation and up to a minute; `contbed warm` does it "
    "beforehand"
)


def choose_cache() -> None:
    """Name a temporary folder for numba where it would find none; says so when it makes one."""
    if VARIABLE in os.environ or "numba" in sys.modules:
        return
    package = Path(__file__).parent / "dem"  # each of its folders is as writable as the others
    home = _cache_of_the_user()
    if _can_write(package / "__pycache__") or (home is not None and _can_write(home / "numba")):
        return
    import tempfile  # takes longer to import than all of this

    folder = Path(tempfile.gettempdir()) / f"contbed-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
    try:
        folder.mkdir(mode=0o700)
        made = True
    except OSError:
        made = False
    if not _is_mine(folder):  # code of others must not run
        folder, made = Path(tempfile.mkdtemp(prefix="contbed-")), True
    os.environ[VARIABLE] = str(folder)
    if made:
        others = f"neither {package.parent} nor {home or 'a home folder'} can be written"
        print(
            f"contbed: compiled code is kept in {folder}, as {others}; {VARIABLE} names another folder",
            file=sys.stderr,
        )


def tell_when_compiling() -> None:
    """Say on stderr, once for a process, that kernels are compiled, as soon as the first one is."""
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
    """Return the folder for caches of this user; None for an account without a home folder."""
    if named := os.environ.get("XDG_CACHE_HOME"):
        return Path(named)
    try:
        return Path("~/.cache").expanduser()
    except RuntimeError:
        return None


def _can_write(folder: Path) -> bool:
    """Whether a folder, or the nearest one above it that exists, can be written."""
    there = next((path for path in (folder, *folder.parents) if path.exists()), None)
    return there is not None and there.is_dir() and os.access(there, os.W_OK | os.X_OK)


def _is_mine(folder: Path) -> bool:
    try:
        status = folder.lstat()
    except OSError:
        return False
    mine = not hasattr(os, "getuid") or (status.st_uid == os.getuid() and not status.st_mode & 0o077)
    return stat.S_ISDIR(status.st_mode) and mine
