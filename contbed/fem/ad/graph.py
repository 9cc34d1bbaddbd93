"""Pointwise forms recorded as graphs: what is computed from what, each operation once.

A form is run on `Node` values, which follow numpy's ufunc protocol as dual numbers do.
What two parts of a form compute alike is one node. Comparisons and choices (`where`,
`minimum`, `maximum`) are operations too, so that another state may take the other
branch. A graph is evaluated with its derivatives by numpy (`ad.batched`), or becomes a
form of UFL (`contbed.ranks.recording`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from hashlib import sha256
from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.fem.ad.dual import (
    _BINARY,
    _COMPARISONS,
    _UNARY,
    Components,
    Dual,
    Linear,
    Symbolic,
    plain,
)

Function = Callable[[Any], Any]
LOGICAL = {
    np.logical_and: np.logical_and,
    np.logical_or: np.logical_or,
    np.logical_not: np.logical_not,
    np.bitwise_and: np.logical_and,
    np.bitwise_or: np.logical_or,
    np.invert: np.logical_not,
}  # what conditions are combined by; they are kept as 0 and 1
RECORDED: dict[Any, Any] = {
    **{ufunc: ufunc for ufunc in (*_UNARY, *_BINARY, *_COMPARISONS, np.power)},
    **LOGICAL,
    np.float_power: np.power,
}
SPECIAL_POWERS: dict[float, Any] = {
    2.0: np.square,
    0.5: np.sqrt,
    1.0: np.positive,
    -1.0: np.reciprocal,
}
LEAVES = ("slot", "known", "x", "h", "number", "array", "parameter")
# second operand
NEUTRAL: dict[Any, float] = {
    np.add: 0.0,
    np.subtract: 0.0,
    np.multiply: 1.0,
    np.divide: 1.0,
}


class NotRecordableError(TypeError):
    """A form asks for the values of its arguments, so that it is no fixed sequence
    of operations.
    """


class Graph:
    """Operations in the order in which they were recorded, each with the numbers of its
    operands.

    Attributes
    ----------
    operations : a ufunc, "where", "table" (a function given with its derivative),
        "frozen" (a value without derivatives), or one of LEAVES: "slot" of an unknown,
        "known" field, coordinate "x", length "h" of cells, "number", "array",
        "parameter" (a number that may change)
    operands : numbers of nodes; for a leaf the number, the array or the slot; for a
        "table" the function, its derivative and the number of its argument
    evaluate : returns the value of a node at the present state; None where values are
        recorded as "frozen"

    """

    def __init__(self, evaluate: Callable[[int], Any] | None = None) -> None:
        self.evaluate = evaluate
        self.operations: list[Any] = []
        self.operands: list[tuple[Any, ...]] = []
        self._known: dict[Any, int] = {}

    def add(self, operation: Any, *operands: Any) -> Node:
        """Return the node of an operation, a new one if there is none."""
        return Node(self, self._number((operation, *operands), operation, operands))

    def _number(self, key: Any, operation: Any, operands: tuple[Any, ...]) -> int:
        number = self._known.setdefault(key, len(self.operations))
        if number == len(self.operations):
            self.operations.append(operation)
            self.operands.append(operands)
        return number

    def parameter(self) -> Node:
        """Return the number on which a family of forms depends; programs receive its
        value.
        """
        return self.add("parameter")

    def leaf(self, item: Any) -> Node:
        """Return a node as it is, a number or an array as a node."""
        if isinstance(item, Node):
            return item
        if np.ndim(item) == 0:
            return self.add("number", float(item))
        values = np.asarray(item, dtype=float)
        content = sha256(np.ascontiguousarray(values)).digest()
        return Node(
            self, self._number(("array", values.shape, content), "array", (values,))
        )

    def number(self, place: int) -> float | None:
        """Return the number that a node stands for; None for anything else."""
        return (
            float(self.operands[place][0])
            if self.operations[place] == "number"
            else None
        )

    def live(self, results: Iterable[int]) -> list[int]:
        """Return the nodes on which results depend, operands first."""
        return live(self._below, results)

    def _below(self, place: int) -> tuple[int, ...]:
        """Return the operands of a node that are nodes."""
        operation, operands = self.operations[place], self.operands[place]
        return (
            ()
            if operation in LEAVES
            else operands[2:]
            if operation == "table"
            else operands
        )

    def values(
        self, results: Sequence[int], leaf: Callable[[str, tuple[Any, ...]], Any]
    ) -> list[Any]:
        """Return the values of nodes; `leaf` returns those of slots, known fields,
        coordinates and lengths.
        """
        done: dict[int, Any] = {}
        for place in self.live(results):
            operation, operands = self.operations[place], self.operands[place]
            below = [done[k] for k in self._below(place)]
            if operation in ("number", "array"):
                done[place] = operands[0]
            elif operation in LEAVES:
                done[place] = leaf(operation, operands)
            elif operation == "table":
                done[place] = operands[0](*below)
            else:
                done[place] = (
                    np.where(*below) if operation == "where" else operation(*below)
                )
        return [done[place] for place in results]

    def apply(self, ufunc: Any, places: list[int]) -> Node:
        """Return the node of a ufunc; numbers are computed at once, and sums with 0 and
        products with 1 are left out.

        Raises
        ------
        NotRecordableError : the ufunc is none that a form may use

        """
        if ufunc not in RECORDED:
            raise NotRecordableError(f"numpy.{ufunc.__name__} is not recorded")
        ufunc, numbers = RECORDED[ufunc], [self.number(place) for place in places]
        if None not in numbers:
            return self.leaf(float(ufunc(*numbers)))
        if ufunc is np.positive:
            return Node(self, places[0])
        if len(places) == 2:
            first, second = numbers
            if ufunc is np.power and second in SPECIAL_POWERS:
                return self.apply(SPECIAL_POWERS[second], places[:1])
            if ufunc is np.multiply and places[0] == places[1]:
                return self.add(np.square, places[0])
            if second is not None and second == NEUTRAL.get(ufunc):
                return Node(self, places[0])
            if (
                first is not None
                and ufunc in (np.add, np.multiply)
                and first == NEUTRAL[ufunc]
            ):
                return Node(self, places[1])
        return self.add(ufunc, *places)


class Node(Symbolic):
    """A pointwise value: the number of its operation in a graph."""

    __slots__ = ("graph", "place")

    def __init__(self, graph: Graph, place: int):
        self.graph, self.place = graph, place

    @property
    def value(self) -> Any:
        """The same value as a constant: without derivatives."""
        if self.graph.evaluate is not None:
            return self.graph.evaluate(self.place)
        return self.graph.add("frozen", self.place)

    def apply(self, f: Function, derivative: Function) -> Node:
        """Record a function given with its derivative; both are evaluated anew at
        each state.
        """
        return self.graph.add("table", f, derivative, self.place)

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any
    ) -> Any:
        if any(isinstance(item, Linear | Components) for item in inputs):
            return NotImplemented
        if self._beside_values(inputs):
            return getattr(ufunc, method)(*_values(inputs), **kwargs)
        if method != "__call__" or kwargs:
            raise NotRecordableError(
                f"numpy.{ufunc.__name__} is recorded only as a function of values"
            )
        return self.graph.apply(ufunc, [self.graph.leaf(item).place for item in inputs])

    def __array_function__(
        self, function: Any, types: Any, args: Any, kwargs: Any
    ) -> Any:
        if function is not np.where or len(args) != 3:
            raise NotRecordableError(f"numpy.{function.__name__} is not recorded")
        if self._beside_values(args):
            return np.where(*_values(args))
        condition, yes, no = (self.graph.leaf(item) for item in args)
        known = self.graph.number(condition.place)
        if known is not None:
            return yes if known else no
        return self.graph.add("where", condition.place, yes.place, no.place)

    def _beside_values(self, items: Iterable[Any]) -> bool:
        """Return whether dual numbers are among some items, so that the values of
        nodes are wanted.
        """
        return self.graph.evaluate is not None and any(
            isinstance(item, Dual) for item in items
        )

    def _refuse(self, *_: Any) -> Any:
        raise NotRecordableError(
            "the form uses the value of a recorded quantity, which is not "
            "known while it is recorded"
        )

    __bool__ = __float__ = __int__ = __len__ = __iter__ = __array__ = _refuse


class Field(Node):
    """The value of a component of an unknown or of a known field, from which its other
    slots are asked for.

    leaf : ("slot", name, component) or ("known", number)
    """

    __slots__ = ("leaf",)

    def __init__(self, graph: Graph, *leaf: Any):
        self.leaf = leaf
        super().__init__(graph, graph.add(*leaf, "v").place)

    def slot(self, kind: Any) -> Node:
        """Return another slot: ("g", k), ("h", k, m) or "low"."""
        return self.graph.add(*self.leaf, kind)


def recorded(
    graph: Graph, system: Any, form: Callable[..., Any], coeffs: Any, ops: Any
) -> dict[Any, Node]:
    """Return the coefficient of each slot of a test (name, component, kind) in what a
    form integrates over a domain.

    Parameters
    ----------
    system : `fem.skfem.System` of the unknowns
    form, coeffs, ops : as `fem.skfem` calls forms

    Raises
    ------
    NotRecordableError : the form is no fixed sequence of operations
    """
    unknowns: dict[str, Any] = {}
    for name, (_, ncomponents) in system.fields.items():
        parts = [Field(graph, "slot", name, k) for k in range(max(ncomponents, 1))]
        unknowns[name] = Components(parts) if ncomponents else parts[0]
    integrand = form(SimpleNamespace(**unknowns), system.tests(), coeffs, ops)
    slots = integrand.slots if isinstance(integrand, Linear) else {}
    return {test: graph.leaf(coefficient) for test, coefficient in slots.items()}


def live(below: Callable[[int], Iterable[int]], results: Iterable[int]) -> list[int]:
    """Return the nodes on which results depend, in ascending order; `below` returns
    the operands of a node.
    """
    found: set[int] = set()
    stack = list(results)
    while stack:
        node = stack.pop()
        if node not in found:
            found.add(node)
            stack += below(node)
    return sorted(found)


def _values(items: Iterable[Any]) -> list[Any]:
    """Return items with the values of nodes in their place."""
    return [plain(item) if isinstance(item, Node) else item for item in items]
