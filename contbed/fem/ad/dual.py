"""Dual numbers and test functions at quadrature points, so that a form yields its exact
Jacobian.

A form is evaluated once at all quadrature points. An unknown enters as `Dual`: its
value and, for each *slot* (value, gradient component, second derivative of one
unknown), the derivative with respect to that slot. A test function enters as `Linear`:
the coefficient of each of its slots. The result is one coefficient array for each pair
(test slot, trial slot), which the assembly contracts with the basis tables. Both obey
numpy's ufunc protocol: closures and materials are ordinary numpy functions and are
differentiated without further code.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

Slot = Any
Array = Any

_UNARY: dict[np.ufunc, Callable[[Array, Array], Array]] = {
    np.negative: lambda a, f: -1.0,
    np.positive: lambda a, f: 1.0,
    np.sqrt: lambda a, f: 0.5 / f,
    np.square: lambda a, f: 2.0 * a,
    np.exp: lambda a, f: f,
    np.log: lambda a, f: 1.0 / a,
    np.log10: lambda a, f: 1.0 / (a * np.log(10.0)),
    np.tanh: lambda a, f: 1.0 - f * f,
    np.sin: lambda a, f: np.cos(a),
    np.cos: lambda a, f: -np.sin(a),
    np.arctan: lambda a, f: 1.0 / (1.0 + a * a),
    np.abs: lambda a, f: np.sign(a),
    np.reciprocal: lambda a, f: -f * f,
}

_BINARY: dict[np.ufunc, Callable[[Array, Array, Array], tuple[Array, Array]]] = {
    np.add: lambda a, b, f: (1.0, 1.0),
    np.subtract: lambda a, b, f: (1.0, -1.0),
    np.multiply: lambda a, b, f: (b, a),
    np.divide: lambda a, b, f: (1.0 / b, -f / b),
    np.maximum: lambda a, b, f: (1.0 * (a >= b), 1.0 * (a < b)),
    np.minimum: lambda a, b, f: (1.0 * (a <= b), 1.0 * (a > b)),
}

_NONE: dict[Slot, Array] = {}  # derivatives of a constant
_COMPARISONS = {
    np.less,
    np.less_equal,
    np.greater,
    np.greater_equal,
    np.equal,
    np.not_equal,
}


def _combine(parts: list[tuple[dict[Slot, Array], Array]]) -> dict[Slot, Array]:
    """Return the sum of `factor * tangents` over parts; a factor that is the number
    1 is not multiplied.
    """
    total: dict[Slot, Array] = {}
    for tangents, factor in parts:
        unit = isinstance(factor, float) and factor == 1.0
        for slot, tangent in tangents.items():
            term = tangent if unit else tangent * factor
            total[slot] = total[slot] + term if slot in total else term
    return total


class Dual(NDArrayOperatorsMixin):
    """A value at all quadrature points with its derivative to each slot it depends
    on.
    """

    __slots__ = ("tangents", "value")

    def __init__(self, value: Array, tangents: dict[Slot, Array]):
        self.value = value
        self.tangents = tangents

    def apply(
        self, f: Callable[[Array], Array], derivative: Callable[[Array], Array]
    ) -> Dual:
        """Apply a function given with its derivative; property tables enter a form
        this way.
        """
        if not self.tangents:
            return Dual(f(self.value), {})
        return Dual(f(self.value), _combine([(self.tangents, derivative(self.value))]))

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any
    ) -> Any:
        if method != "__call__" or kwargs:
            return NotImplemented
        values, tangents = [], []
        for item in inputs:
            if isinstance(item, _OTHERS):
                return NotImplemented
            of_dual = isinstance(item, Dual)
            values.append(item.value if of_dual else item)
            tangents.append(item.tangents if of_dual else _NONE)
        if ufunc in _COMPARISONS:
            return ufunc(*values)
        if not any(tangents):  # a constant, such as a speed of 0, needs no derivative
            return Dual(ufunc(*values), {})
        if ufunc in (np.power, np.float_power):
            return self._power(values, tangents)
        result = ufunc(*values)
        if len(values) == 1 and ufunc in _UNARY:
            return Dual(
                result, _combine([(tangents[0], _UNARY[ufunc](values[0], result))])
            )
        if ufunc in _BINARY:
            first, second = _BINARY[ufunc](values[0], values[1], result)
            return Dual(result, _combine([(tangents[0], first), (tangents[1], second)]))
        raise TypeError(
            f"forms and closures may not use numpy.{ufunc.__name__}: it has no "
            "derivative rule"
        )

    @staticmethod
    def _power(values: list[Array], tangents: list[dict[Slot, Array]]) -> Dual:
        base, exponent = values
        result = base**exponent
        parts = [(tangents[0], exponent * base ** (exponent - 1.0))]
        if tangents[1]:
            parts.append((tangents[1], result * np.log(base)))
        return Dual(result, _combine(parts))

    def __array_function__(
        self, function: Any, types: Any, args: Any, kwargs: Any
    ) -> Any:
        if function is not np.where or any(isinstance(item, Symbolic) for item in args):
            return NotImplemented
        condition, yes, no = np.asarray(args[0]), args[1], args[2]
        chosen = np.where(
            condition, getattr(yes, "value", yes), getattr(no, "value", no)
        )
        parts = [
            (getattr(yes, "tangents", {}), 1.0 * condition),
            (getattr(no, "tangents", {}), 1.0 * ~condition),
        ]
        return Dual(chosen, _combine(parts))


def plain(value: Any) -> Any:
    """Return the value of a dual number; other values as they are."""
    return getattr(value, "value", value)


class Linear(NDArrayOperatorsMixin):
    """A linear expression in the test functions: the coefficient of each test slot."""

    __slots__ = ("slots",)

    def __init__(self, slots: dict[Slot, Any]):
        self.slots = slots

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any
    ) -> Any:
        a: Any = inputs[0]
        b: Any = inputs[1] if len(inputs) == 2 else None
        if isinstance(a, Components) or isinstance(b, Components):
            return NotImplemented
        if ufunc is np.negative:
            return Linear({slot: -c for slot, c in a.slots.items()})
        if ufunc is np.multiply and not (
            isinstance(a, Linear) and isinstance(b, Linear)
        ):
            linear, factor = (a, b) if isinstance(a, Linear) else (b, a)
            return Linear({slot: c * factor for slot, c in linear.slots.items()})
        if ufunc is np.divide and isinstance(a, Linear):
            return Linear({slot: c / b for slot, c in a.slots.items()})
        if ufunc in (np.add, np.subtract):
            if isinstance(a, Linear) and isinstance(b, Linear):
                total = dict(a.slots)
                for slot, c in b.slots.items():
                    term = c if ufunc is np.add else -c
                    total[slot] = total[slot] + term if slot in total else term
                return Linear(total)
            zero = b if isinstance(a, Linear) else a
            if isinstance(zero, int | float) and zero == 0:
                return a if isinstance(a, Linear) else (b if ufunc is np.add else -b)
        raise TypeError("a form must be linear in its test functions")


class Components:
    """A vector or matrix of pointwise values; entries are numbers, arrays, `Dual` or
    `Linear`, rows are Components.
    """

    __slots__ = ("items",)
    __array_ufunc__ = None

    def __init__(self, items: Any):
        self.items = tuple(items)

    def __len__(self) -> int:
        return len(self.items)

    def __getitem__(self, index: int) -> Any:
        return self.items[index]

    def __add__(self, other: Components) -> Components:
        return Components(a + b for a, b in zip(self.items, other.items, strict=True))

    def __sub__(self, other: Components) -> Components:
        return Components(a - b for a, b in zip(self.items, other.items, strict=True))

    def __neg__(self) -> Components:
        return Components(-a for a in self.items)

    def __mul__(self, factor: Any) -> Components:
        return Components(a * factor for a in self.items)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Any) -> Components:
        return Components(a / divisor for a in self.items)


class Symbolic(NDArrayOperatorsMixin):
    """A pointwise value that is recorded and computed later, see `ad.graph`."""

    __slots__ = ()


_OTHERS = (Linear, Components, Symbolic)
