"""What the evaluation of a graph of operations needs that does not depend on the
numbers in it: found once, kept.

Forms that differ only in the values of their coefficients, as those of the points of a
continuation and of the scenes of a sweep do, have the same operations with the same
operands. They share one plan: which nodes are live, the row of each, the rules of its
derivatives, and the order in which those are multiplied and added (`ad.elimination`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from contbed.arrays import Array
from contbed.fem.ad.dual import _BINARY, _UNARY
from contbed.fem.ad.elimination import Elimination
from contbed.fem.ad.graph import LEAVES, Graph, live

KEPT = 32  # plans, of a few hundred kilobytes each; a bed that reacts has five


class Structure(NamedTuple):
    """A graph without its values: equal for graphs that are evaluated alike.

    operations : as in the graph
    operands : numbers of nodes; (name, component, kind) of a slot, nothing for other
        leaves
    results : nodes that are wanted
    """

    operations: tuple[Any, ...]
    operands: tuple[tuple[Any, ...], ...]
    results: tuple[int, ...]


def structure(graph: Graph, results: Sequence[int]) -> Structure:
    """Return the structure of a graph with its results."""
    # what is left of operands with values
    valued = {"number": slice(0), "array": slice(0), "table": slice(2, 3)}
    everything = slice(None)
    operands = (
        items[valued.get(operation, everything)]
        for operation, items in zip(graph.operations, graph.operands, strict=True)
    )
    return Structure(tuple(graph.operations), tuple(operands), tuple(results))


class Plan:
    """The order of evaluation of a structure.

    Attributes
    ----------
    live : nodes on which results depend, operands first
    operands : by node, those that are nodes
    row : by node, the row of its values; those of slots come first, in the order of
        `slots`
    slots : (name, component, kind) of the unknowns that are read
    parameter : row of the parameter; None where results do not depend on it
    one, minus : rows that hold 1 and -1
    slopes : (rule, which operand, rows of the operands, node) of the derivatives that
        are computed by rules, which fill the rows after `minus`; the rule of a table is
        None, as each table is given its own
    derivatives : (number of the result, number of the slot, row) of all that are not
        zero everywhere
    batches : what computes them, in order
    size : number of rows that are needed
    results : rows of the results

    """

    def __init__(self, what: Structure):
        self._operations = what.operations
        self.operands = [
            () if operation in LEAVES else items
            for operation, items in zip(what.operations, what.operands, strict=True)
        ]
        self.live = live(self.operands.__getitem__, what.results)
        slots = [k for k in self.live if what.operations[k] == "slot"]
        others = [k for k in self.live if what.operations[k] != "slot"]
        self.slots = [what.operands[k] for k in slots]
        self.row = {k: row for row, k in enumerate([*slots, *others])}
        self.results = [self.row[k] for k in what.results]
        self.parameter = next(
            (self.row[k] for k in others if what.operations[k] == "parameter"), None
        )
        self.one, self.minus = len(self.row), len(self.row) + 1
        self.slopes: list[
            tuple[Callable[..., Any] | None, int, tuple[int, ...], int]
        ] = []
        edges = self._edges(what.results)
        found = Elimination(
            edges, set(slots), what.results, self.one, self.minus + 1 + len(self.slopes)
        )
        place = {k: n for n, k in enumerate(slots)}
        self.derivatives = [
            (result, place[leaf], row) for result, leaf, row in found.derivatives
        ]
        self.batches, self.size = found.batches, found.end

    def _edges(self, results: Sequence[int]) -> list[tuple[int, int, int]]:
        """Return (operand, node, row) of all derivatives; those that are computed by
        rules join `slopes`.
        """
        active: set[int] = set()
        edges: list[tuple[int, int, int]] = []
        for node in self.live:
            operation = self._operations[node]
            if operation == "slot":
                active.add(node)
            if operation == "frozen":
                continue
            for which, operand in enumerate(self.operands[node]):
                if operand in active and not (operation == "where" and which == 0):
                    found = self._slope(operation, node, which)
                    if found is not None:
                        edges.append((operand, node, found))
                        active.add(node)
        # what results depend on otherwise than through values without derivatives
        used = set(results)
        kept = []
        for edge in reversed(edges):
            if edge[1] in used:
                used.add(edge[0])
                kept.append(edge)
        return kept

    def _slope(self, operation: Any, node: int, which: int) -> int | None:
        """Return the row of the derivative of a node to one of its operands; None
        where it is zero everywhere.
        """
        if operation is np.add or (operation is np.subtract and which == 0):
            return self.one
        if operation is np.negative or operation is np.subtract:
            return self.minus
        operands = self.operands[node]
        if operation is np.multiply:
            return self.row[operands[1 - which]]
        rows = tuple(self.row[k] for k in operands)
        rule: Callable[..., Any] | None
        if operation == "where":
            rows = rows[:1]
            rule = (lambda c, f: c != 0.0) if which == 1 else (lambda c, f: c == 0.0)
        elif operation == "table":
            rule = None
        elif operation is np.power:
            number = self._operations[operands[1]] == "number"
            rule = (lambda a, e, f: e * a ** (e - 1.0)) if number else _of_power
        elif operation in _BINARY or operation in _UNARY:
            rule = _BINARY.get(operation) or _UNARY[operation]
        else:
            return None
        self.slopes.append((rule, which, rows, node))
        return self.minus + len(self.slopes)


def _of_power(base: Array, exponent: Array, value: Array) -> tuple[Array, Any]:
    return exponent * base ** (exponent - 1.0), value * np.log(base)


@lru_cache(maxsize=KEPT)
def planned(what: Structure) -> Plan:
    """Return the plan of a structure, found when it is first asked for."""
    return Plan(what)
