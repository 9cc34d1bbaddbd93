"""Forms recorded as data: the operations of a form are recorded once and replayed where the form is compiled.

A form over `ops` is run on `Recorded` values. Each remembers the operation that made it and its operands, down to the
leaves: slots of unknowns, tests and known fields, coordinates, arrays at the quadrature points, numbers. A recorded
form is a list of plain tuples that any process can turn into UFL (`fem.dolfinx`), so only one process needs the
models, the closures and the materials. Known values stay available as arrays, computed when they are asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.errors import ContbedError
from contbed.fem.ad.dual import _BINARY, _COMPARISONS, _UNARY, Components, Dual, Linear
from contbed.fem.domain import Domain
from contbed.fem.skfem import Ops, System, _Unknown

LOGICAL = {np.logical_and, np.logical_or, np.logical_not, np.bitwise_and, np.bitwise_or, np.invert}
ALLOWED = {*_UNARY, *_BINARY, *_COMPARISONS, *LOGICAL, np.power, np.float_power}


class Recorded(Dual):
    """A pointwise value that remembers how it was made; `operands` are Recorded, or the data of a leaf."""

    __slots__ = ("on", "operands", "operation")
    plain = False

    def __init__(self, on: Tape, operation: str, *operands: Any):
        self.on, self.operation, self.operands = on, operation, operands

    tangents: Any = property(lambda self: {})  # as a dual number it is a constant

    @property
    def value(self) -> Any:
        """The array that this value stands for, with unknowns from the last state."""
        return self.on.value(self, {})

    def apply(self, f: Callable[[Any], Any], derivative: Callable[[Any], Any]) -> Recorded:
        """Record a function with its derivative; both are evaluated anew at each assembly."""
        return Recorded(self.on, "table", f, derivative, self)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method != "__call__" or kwargs or any(isinstance(item, Linear | Components) for item in inputs):
            return NotImplemented
        if any(isinstance(item, Dual) and not isinstance(item, Recorded) for item in inputs):
            return super().__array_ufunc__(ufunc, method, *inputs, **kwargs)
        if ufunc not in ALLOWED:
            raise TypeError(f"forms and closures may not use numpy.{ufunc.__name__}: it has no counterpart in UFL")
        return Recorded(self.on, ufunc.__name__, *(self.on.leaf(item) for item in inputs))

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function is not np.where or any(isinstance(a, Dual) and not isinstance(a, Recorded) for a in args):
            return super().__array_function__(function, types, args, kwargs)
        return Recorded(self.on, "where", *(self.on.leaf(item) for item in args))


class Field(Recorded):
    """A leaf that is a slot of an unknown, a test or a known field; `operation` says which of them."""

    __slots__ = ()

    def slot(self, kind: Any) -> Field:
        """Return another slot of the same field: "v", ("g", k), ("h", k, m) or "low"."""
        return Field(self.on, self.operation, *self.operands[:-1], kind)


@dataclass(eq=False)
class KnownField:
    """A finite-element field with known values (size,) on a space."""

    space: Any
    values: Any

    def __eq__(self, other: object) -> bool:
        """Return whether both fields use the same memory."""
        return isinstance(other, KnownField) and self._place == other._place

    __hash__ = None  # type: ignore[assignment]

    @property
    def _place(self) -> Any:
        return self.values.__array_interface__["data"], self.values.strides, self.values.shape


@dataclass(frozen=True)
class Recording:
    """A form as data: `entries` are tuples (operation, operands).

    Operands are numbers of earlier entries, or the data of a leaf. Arrays and known fields are kept beside the entries
    and referred to by number. `tables` holds (number of the first of three arrays, function, derivative, argument): the
    three arrays are the value, the derivative and the argument of a property table, and the functions renew them.
    """

    entries: tuple[Any, ...]
    arrays: list[Any]
    known: list[KnownField]
    tables: list[tuple[int, Callable[[Any], Any], Callable[[Any], Any], Recorded]]


@dataclass(eq=False)
class Tape:
    """Recorder of forms on one domain of a system; the last state gives the values of the unknowns."""

    system: System
    where: Domain
    state: Any = None
    components: list[tuple[str, int]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.components = [*self.system.offset]

    def leaf(self, item: Any) -> Recorded:
        """Return a number or an array as Recorded."""
        if isinstance(item, Recorded):
            return item
        if np.ndim(item) == 0:
            return Recorded(self, "number", float(item))
        return Recorded(self, "array", np.asarray(item, dtype=float))

    def fields(self, operation: str) -> dict[str, Any]:
        """Return all unknowns, or all tests, by name."""
        out: dict[str, Any] = {}
        for name, (_, ncomponents) in self.system.fields.items():
            parts = [Field(self, operation, (name, c), "v") for c in range(max(ncomponents, 1))]
            out[name] = Components(parts) if ncomponents else parts[0]
        return out

    def known(self, space: Any, values: Any) -> Any:
        """Return a known field as Recorded; a vector where it has components."""
        if values.ndim == 1:
            return Field(self, "known", KnownField(space, values), "v")
        return Components(self.known(space, row) for row in values)

    def value(self, item: Recorded, memory: dict[int, Any]) -> Any:
        """Return the number or array of a recorded value."""
        if id(item) not in memory:
            memory[id(item)] = self._value(item, memory)
        return memory[id(item)]

    def _value(self, item: Recorded, memory: dict[int, Any]) -> Any:
        operation, operands = item.operation, item.operands
        if operation in ("number", "array"):
            return operands[0]
        if operation in ("x", "h"):
            return self.where.x[operands[0]] if operation == "x" else self.where.h
        if operation == "test":
            raise TypeError("a test function has no value")
        if operation in ("unknown", "known"):
            where, (what, kind) = self.where, operands
            if operation == "known":
                space, values = what.space, what.values[what.space.dofs[:, where.cells].T]
            else:
                space = self.system.fields[what[0]][0]
                values = self.state[self.system.offset[what] + space.dofs[:, where.cells].T]
            known = _Unknown(where, space, values, None)
            return known.value if kind == "v" else known.slot(kind).value
        if operation == "table":
            return operands[0](self.value(operands[2], memory))
        values = [self.value(operand, memory) for operand in operands]
        return getattr(np, operation)(*values)

    def record(self, integrand: Recorded) -> Recording:
        """Record everything that a value depends on, as data."""
        entries: list[Any] = []
        numbers: dict[int, int] = {}
        out = Recording((), [], [], [])

        def add(*entry: Any) -> int:
            entries.append(entry)
            return len(entries) - 1

        def array(values: Any) -> int:
            found = next((k for k, other in enumerate(out.arrays) if other is values), None)
            if found is None:
                out.arrays.append(values)
                found = len(out.arrays) - 1
            return add("array", found)

        def visit(item: Recorded) -> int:
            operation, operands = item.operation, item.operands
            if operation == "array":
                return array(operands[0])
            if operation in ("unknown", "test"):
                return add(operation, self.components.index(operands[0]), operands[1])
            if operation == "known":
                if operands[0] not in out.known:
                    out.known.append(operands[0])
                return add("known", out.known.index(operands[0]), operands[1])
            if operation in ("number", "x", "h"):
                return add(operation, *operands)
            if operation == "table":
                f, derivative, argument = operands
                below = numbers[id(argument)]
                first = len(out.arrays)
                out.tables.append((first, f, derivative, argument))
                shape = self.where.shape
                parts = [array(np.zeros(shape)) for _ in range(3)]
                step = add("subtract", below, parts[2])
                return add("add", parts[0], add("multiply", parts[1], step))
            return add(operation, *(numbers[id(operand)] for operand in operands))

        for item in _in_order(integrand):
            numbers[id(item)] = visit(item)
        return Recording(tuple(entries), out.arrays, out.known, out.tables)

    def renew(self, recording: Recording) -> list[int]:
        """Evaluate all tables at the present state; return the numbers of the arrays that change."""
        memory: dict[int, Any] = {}
        for first, f, derivative, argument in recording.tables:
            T = self.value(argument, memory)
            for k, values in enumerate((f(T), derivative(T), T)):
                recording.arrays[first + k][:] = values
        return [first + k for first, *_ in recording.tables for k in range(3)]


class TapeOps(Ops):
    """The operators of forms on recorded values."""

    def __init__(self, tape: Tape):
        x = Components(Recorded(tape, "x", k) for k in range(tape.where.dim))
        super().__init__(tape.where, x, Recorded(tape, "h"))


def _in_order(root: Recorded) -> list[Recorded]:
    """Return all values that `root` depends on, operands before the values made of them."""
    done: dict[int, Recorded] = {}
    stack = [root]
    while stack:
        item = stack[-1]
        open_ = [o for o in item.operands if isinstance(o, Recorded) and id(o) not in done]
        if open_:
            stack += open_
            continue
        done.setdefault(id(stack.pop()), item)
    return list(done.values())


def integrand(tape: Tape, forms: Any) -> Recorded | None:
    """Return the sum of what `forms` (form, domain, coefficients) integrate over the domain of a tape."""
    unknowns, tests = (SimpleNamespace(**tape.fields(what)) for what in ("unknown", "test"))
    total: Any = 0.0
    for form, where, coeffs in forms:
        if where is not tape.where:
            raise ContbedError("a form belongs to another domain")
        total = total + form(unknowns, tests, coeffs, TapeOps(tape))
    return total if isinstance(total, Recorded) else None
