"""Recorded forms as data: the entries of a graph that all ranks turn into UFL, with the
arrays and fields in them.

Only rank 0 needs the models, closures and materials. Property tables have no expression
in UFL: between two assemblies they are linear, about the present state.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.fem.ad.graph import Graph, Node


@dataclass(eq=False)
class KnownField:
    """A finite-element field with known values (size,) on a space."""

    space: Any
    values: Any

    def __eq__(self, other: object) -> bool:
        """Return whether both fields use the same memory."""
        return isinstance(other, KnownField) and self._memory == other._memory

    __hash__ = None  # type: ignore[assignment]

    @property
    def _memory(self) -> Any:
        return (
            self.values.__array_interface__["data"],
            self.values.strides,
            self.values.shape,
        )


@dataclass(frozen=True)
class Recording:
    """The sum of coefficients times slots of tests, as data.

    Attributes
    ----------
    entries : (operation, operands), in the order in which they are evaluated: operands
        are numbers of entries, and for leaves (number, value), (array, number of the
        array), (slot, number of the unknown, kind), (known, number of the field, kind),
        (x, axis), (h,); a table is (table, number of the first of its three arrays,
        entry)
    results : number of the unknown, kind of its test, and entry of the coefficient
    arrays : at the quadrature points (ncells, points) or in the cells (ncells, 1)
    known : numbers of known fields
    tables : number of the first of three arrays, the value, the derivative and the
        argument of a table; its function, derivative and the node of its argument
    """

    entries: tuple[Any, ...]
    results: tuple[tuple[int, Any, int], ...]
    arrays: list[Any]
    known: list[int]
    tables: list[tuple[int, Callable[[Any], Any], Callable[[Any], Any], int]]

    def renew(self, values: Callable[[Sequence[int]], Sequence[Any]]) -> list[int]:
        """Evaluate all tables where nodes have some `values`; return the numbers of
        the arrays that change.
        """
        changed = []
        arguments = values([argument for *_, argument in self.tables])
        for (first, function, derivative, _), argument in zip(
            self.tables, arguments, strict=True
        ):
            for k, found in enumerate(
                (function(argument), derivative(argument), argument)
            ):
                self.arrays[first + k][:] = found
                changed.append(first + k)
        return changed


def recording_of(
    graph: Graph,
    coefficients: Mapping[Any, Node],
    unknowns: Sequence[tuple[str, int]],
    shape: tuple[int, int],
) -> Recording:
    """Return the recording of coefficients by the slot (name, component, kind) of their
    test.

    Parameters
    ----------
    unknowns : all (name, component), in their order
    shape : (cells, quadrature points of each)
    """
    results = {test: node.place for test, node in coefficients.items()}
    out = Recording((), (), [], [], [])
    entries: list[Any] = []
    numbers: dict[int, int] = {}
    for place in graph.live(results.values()):
        operation, operands = graph.operations[place], graph.operands[place]
        if operation == "array":
            operands = (len(out.arrays),)
            out.arrays.append(graph.operands[place][0])
        elif operation == "slot":
            operands = (unknowns.index(operands[:2]), operands[2])
        elif operation == "known":
            field, kind = operands
            if field not in out.known:
                out.known.append(field)
            operands = (out.known.index(field), kind)
        elif operation == "table":
            function, derivative, argument = operands
            first = len(out.arrays)
            out.tables.append((first, function, derivative, argument))
            out.arrays.extend(np.zeros(shape) for _ in range(3))
            operands = (first, numbers[argument])
        elif operation not in ("number", "x", "h"):
            operands = tuple(numbers[k] for k in operands)
        numbers[place] = len(entries)
        entries.append((operation, *operands))
    found = [
        (unknowns.index(test[:2]), test[2], numbers[place])
        for test, place in results.items()
    ]
    return Recording(tuple(entries), tuple(found), out.arrays, out.known, out.tables)
