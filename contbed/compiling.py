"""Compiled functions that only other compiled functions call: without an entry from Python they compile in less time.

The entry unpacks and checks each array of each argument, half of what a kernel of many arrays takes to compile. Python
must not call such a function: the process would end without a word.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., object])


def inner(**options: Any) -> Callable[[Function], Function]:
    """Make a decorator that compiles a function with numba's options and without an entry from Python."""
    compiled: Callable[..., Any] = njit
    return cast("Callable[[Function], Function]", compiled(no_cpython_wrapper=True, **options))
