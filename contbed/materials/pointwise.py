"""Tables for dual numbers: apply a function given by its value and its derivative at
every point.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

# of a derivative, so small beside any argument that its square is lost in rounding
COMPLEX_STEP = 1e-20


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


def analytic(f: Callable[[Any], Any], T: Any) -> Any:
    """Return f(T) of an analytic function, with its derivative by a complex step, exact
    to round-off, when T is a dual number.

    One derivative at each point costs less than those of every operation by every
    unknown. Values that are recorded keep their operations. Squire and Trapp (1998),
    SIAM Rev. 40, 110, doi:10.1137/S003614459631241X.
    """
    if not hasattr(T, "tangents"):
        return f(T)
    return T.apply(f, lambda at: f(at + 1j * COMPLEX_STEP).imag / COMPLEX_STEP)


def with_slopes(
    f: Callable[[Any], tuple[Any, Any]], inputs: Sequence[Any]
) -> list[Any]:
    """Return several functions of several inputs that are found at all points at once,
    with the derivatives by inputs that are dual numbers.

    Parameters
    ----------
    f : gives values (functions, N) and derivatives (functions, inputs, N) at inputs
        (inputs, N)
    inputs : numbers, arrays or dual numbers
    """
    plain = [np.asarray(getattr(z, "value", z), dtype=float) for z in inputs]
    shape = np.broadcast_shapes(*(z.shape for z in plain))
    values, slopes = f(np.array([np.broadcast_to(z, shape).ravel() for z in plain]))
    out = []
    for value, slope in zip(values, slopes, strict=True):
        found: Any = value.reshape(shape)
        for z, given, part in zip(inputs, plain, slope, strict=True):
            if hasattr(z, "tangents"):
                found = found + (z - given) * part.reshape(shape)
        out.append(found)
    return out
