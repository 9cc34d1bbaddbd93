"""Compiled functions that call each other: without entries that are not needed, and
anew when one of them changes.

The entry from Python unpacks and checks each array of each argument, half of what a
kernel of many arrays takes to compile. Python must not call a function without it: the
process would end silently. Numba makes another entry from C for each function, which
nothing here calls.

Code on disk holds that of all functions that it calls, but numba makes it anew only
where the file of the calling one has changed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., object])


def entry(**options: Any) -> Callable[[Function], Function]:
    """Make a decorator that compiles a function that Python calls, with numba's
    options.
    """
    compiled: Callable[..., Any] = njit
    return cast(
        "Callable[[Function], Function]", compiled(no_cfunc_wrapper=True, **options)
    )


def inner(**options: Any) -> Callable[[Function], Function]:
    """Make a decorator that compiles a function with numba's options and without an
    entry from Python.
    """
    return entry(no_cpython_wrapper=True, **options)


def digest(files: Iterable[Path]) -> str:
    """Return a number of the content of files with compiled functions."""
    found = hashlib.sha256()
    for path in sorted(files):
        found.update(path.read_bytes())
    return found.hexdigest()


def tied(function: Function, content: str) -> Function:
    """Let code on disk of a compiled function hold only as long as `content`, a
    digest of all files that it calls.
    """
    cache = getattr(getattr(function, "_cache", None), "_cache_file", None)
    if cache is not None:  # compiling may be switched off
        cache._source_stamp = (cache._source_stamp, content)
    return function
