"""Derivatives of a graph of operations by elimination of its inner nodes: planned once,
computed at any state.

Each edge of the graph carries the derivative of a node to one of its operands. An inner
node v is eliminated by adding, for each operand p and each user s,

    d s/d p  +=  d s/d v  d v/d p

What is left are the derivatives of the results to the leaves. The node of least cost,
operands times users, comes first (Markowitz): for forms with dozens of unknowns a third
of the products of forward or reverse differentiation.

Source: Griewank, Walther 2008, Evaluating Derivatives, 2nd edition, SIAM, chapter 9,
    doi:10.1137/1.9780898717761
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array

Places = NDArray[np.intp]


class Edge:
    """A derivative: the sum of `terms`, each the number of a row or the product of
    two edges.
    """

    __slots__ = ("level", "pairs", "row", "source", "terms")

    def __init__(self) -> None:
        self.terms: list[Any] = []
        # where the values are: a number of a row, or an edge that is computed
        self.source: Any = self
        # factors of what is computed: numbers of rows, or edges
        self.pairs: list[tuple[Any, Any]] = []
        self.level = 0  # batch that computes it
        self.row = -1  # where that puts it


@dataclass(frozen=True)
class Batch:
    """Sums of products of rows, which become the rows from `start` on.

    first, second : rows of the factors: those of the first products of all sums, then
        of the second ones, and so on
    counts : how many sums have a first product, a second one, and so on; they never
        grow
    """

    start: int
    first: Places
    second: Places
    counts: tuple[int, ...]

    def evaluate(self, rows: Array) -> None:
        """Fill the rows of the sums (rows, points)."""
        products = rows.take(self.first, axis=0)
        products *= rows.take(self.second, axis=0)
        done = self.counts[0]
        sums = rows[self.start : self.start + done]
        sums[:] = products[:done]
        for count in self.counts[1:]:
            sums[:count] += products[done : done + count]
            done += count


class Elimination:
    """The order in which derivatives are multiplied and added.

    Parameters
    ----------
    edges : (operand, node, row) of all derivatives that are computed from values, by
        the number of their row
    leaves : nodes to which derivatives are wanted
    results : nodes whose derivatives are wanted; one node may be several results
    one : row that holds the number 1
    start : first row that is free

    Attributes
    ----------
    derivatives : (number of the result, leaf, row) of all that are not zero everywhere
    batches : what computes them, in order
    end : number of rows that are needed

    """

    def __init__(
        self,
        edges: Iterable[tuple[int, int, int]],
        leaves: set[int],
        results: Sequence[int],
        one: int,
        start: int,
    ):
        self._one = one
        self._into: dict[int, dict[int, Edge]] = {}  # by node: its operands
        self._out_of: dict[int, dict[int, Edge]] = {}  # by operand: its users
        for operand, node, row in edges:
            self._add(operand, node, row)
        # numbers of the results apart from those of nodes, which go
        sinks = [-1 - k for k in range(len(results))]
        for sink, node in zip(sinks, results, strict=True):
            if node in self._into or node in leaves:  # a result may be a constant
                self._add(node, sink, one)
        finished = self._eliminate(leaves)
        found = [
            (k, leaf, edge)
            for k, sink in enumerate(sinks)
            for leaf, edge in self._into.get(sink, {}).items()
        ]
        self.batches, self.end = self._scheduled(
            [*finished, *(edge for *_, edge in found)], start
        )
        self.derivatives = [(k, leaf, _place(edge.source)) for k, leaf, edge in found]

    def _add(self, operand: int, node: int, term: Any) -> None:
        users = self._out_of.setdefault(operand, {})
        if node not in users:
            users[node] = self._into.setdefault(node, {})[operand] = Edge()
        users[node].terms.append(term)

    def _eliminate(self, leaves: set[int]) -> list[Edge]:
        """Eliminate all inner nodes; return the edges that went in the order in
        which they were complete.
        """
        into, out_of, finished = self._into, self._out_of, []
        inner = {node for node in into if node >= 0 and node not in leaves}

        def cost(node: int) -> int:
            return len(into[node]) * len(out_of[node])

        heap = [(cost(node), node) for node in inner]
        heapq.heapify(heap)
        while heap:
            expected, node = heapq.heappop(heap)
            if node not in inner:
                continue
            if (now := cost(node)) != expected:
                heapq.heappush(heap, (now, node))
                continue
            inner.remove(node)
            operands, users = into.pop(node), out_of.pop(node)
            finished += [*operands.values(), *users.values()]
            for user in users:
                del into[user][node]
            for operand, before in operands.items():
                del out_of[operand][node]
                for user, after in users.items():
                    self._add(operand, user, (before, after))
            for other in (*operands, *users):
                if other in inner:
                    heapq.heappush(heap, (cost(other), other))
        return finished

    def _scheduled(self, edges: list[Edge], start: int) -> tuple[list[Batch], int]:
        """Return batches of the edges that do not depend on each other, and the
        number of rows.
        """
        levels: dict[int, list[Edge]] = {}
        for edge in edges:
            edge.pairs = [self._factors(term) for term in edge.terms]
            (first, second), *others = edge.pairs
            if not others and second == self._one:  # no sum and no product
                edge.source = first
                continue
            edge.level = 1 + max(
                _level(factor) for pair in edge.pairs for factor in pair
            )
            levels.setdefault(edge.level, []).append(edge)
        batches = []
        for _, together in sorted(levels.items()):
            together.sort(key=lambda edge: -len(edge.pairs))
            for row, edge in enumerate(together, start):
                edge.row = row
            terms = [
                [e.pairs[k] for e in together if len(e.pairs) > k]
                for k in range(len(together[0].pairs))
            ]
            first, second = (
                np.array(
                    [_place(pair[side]) for group in terms for pair in group],
                    dtype=np.intp,
                )
                for side in (0, 1)
            )
            batches.append(
                Batch(start, first, second, tuple(len(group) for group in terms))
            )
            start += len(together)
        return batches, start

    def _factors(self, term: Any) -> tuple[Any, Any]:
        """Return a term as two factors; a product with 1 has it as the second one."""
        if isinstance(term, int):
            return term, self._one
        first, second = (edge.source for edge in term)
        return (second, first) if first == self._one else (first, second)


def _place(factor: Any) -> int:
    row: int = factor.row if isinstance(factor, Edge) else factor
    return row


def _level(factor: Any) -> int:
    return factor.level if isinstance(factor, Edge) else 0
