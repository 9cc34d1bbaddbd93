"""Tables for dual numbers: apply a function given by its value and its derivative at
every point.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def pointwise(f: Callable[[Any], Any], df: Callable[[Any], Any], T: Any) -> Any:
    """Return f(T), with the exact derivative df when T is a dual number.

    Parameters
    ----------
    f, df : functions of a plain array: the value and its derivative with respect to T
    T : number, array, or a value of a form, whose `apply(f, df)` returns the value of
        the function with its derivative

    Returns
    -------
    f(T), of the kind of T
    """
    if hasattr(T, "apply"):
        return T.apply(f, df)
    return f(T)
