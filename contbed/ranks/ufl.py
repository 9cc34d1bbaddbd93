"""Recorded forms in UFL."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import ufl

UFUNCS: dict[np.ufunc, Callable[..., Any]] = {
    np.negative: lambda a: -a,
    np.sqrt: ufl.sqrt,
    np.square: lambda a: a * a,
    np.exp: ufl.exp,
    np.log: ufl.ln,
    np.log10: lambda a: ufl.ln(a) / float(np.log(10.0)),
    np.tanh: ufl.tanh,
    np.sin: ufl.sin,
    np.cos: ufl.cos,
    np.arctan: ufl.atan,
    np.abs: abs,
    np.reciprocal: lambda a: 1.0 / a,
    np.add: lambda a, b: a + b,
    np.subtract: lambda a, b: a - b,
    np.multiply: lambda a, b: a * b,
    np.divide: lambda a, b: a / b,
    np.power: lambda a, b: a**b,
    np.maximum: ufl.max_value,
    np.minimum: ufl.min_value,
    np.less: ufl.lt,
    np.less_equal: ufl.le,
    np.greater: ufl.gt,
    np.greater_equal: ufl.ge,
    np.equal: ufl.eq,
    np.not_equal: ufl.ne,
    np.logical_and: ufl.And,
    np.logical_or: ufl.Or,
    np.logical_not: ufl.Not,
}
Leaves = Mapping[str, Callable[..., Any]]


def expressions(entries: Iterable[tuple[Any, ...]], leaves: Leaves) -> list[Any]:
    """Return the entries of a `recording.Recording` in UFL.

    leaves : by name, what returns a leaf from its operands; of a number also whether it
        must be in the form as it is
    """
    entries = tuple(entries)
    exponents = {entry[2] for entry in entries if entry[0] is np.power}
    done: list[Any] = []
    for place, (operation, *operands) in enumerate(entries):
        if operation == "number":
            value = leaves["number"](*operands, place in exponents)
        elif operation in leaves:
            value = leaves[operation](*operands)
        elif operation == "table":
            first, argument = operands
            known, slope, at = (leaves["array"](first + k) for k in range(3))
            value = known + slope * (done[argument] - at)
        else:
            function: Callable[..., Any] = (
                ufl.conditional if operation == "where" else UFUNCS[operation]
            )
            value = function(*(done[k] for k in operands))
        done.append(value)
    return done


def slot(field: Any, kind: Any) -> Any:
    """Return the value, the gradient or a second derivative of a field."""
    if kind == "v":
        return field
    return (
        ufl.grad(field)[kind[1]]
        if kind[0] == "g"
        else ufl.grad(ufl.grad(field))[kind[1], kind[2]]
    )
