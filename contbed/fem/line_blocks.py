"""Jacobian of discontinuous polynomials on a line, block tridiagonal: its blocks, and
their factors.

Small blocks are full and make a band. Those of many rings across a bed are sparse, as a
ring exchanges with its neighbours alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided
from scipy.linalg.lapack import dgbtrf, dgbtrs
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from contbed.arrays import Array, Flags, Integers
from contbed.errors import ConvergenceError

WIDEST = (
    # unknowns of a cell up to which factors as a band are no dearer than sparse ones,
    # measured on 3 to 12 rings
    150
)


@dataclass(frozen=True, eq=False)
class Blocks:
    """Derivatives of the residuals of each cell to the unknowns of the cell to its
    left, its own, and the next one.

    exchanged : (k,) increasing: fields that are in a flux or whose equation has one;
        others act at their nodes alone
    lower, own, upper : (N, k, n, k, n) of these, by equation and node, and by field and
        node
    sources : (m, m, N, n) of the sources of all equations, by equation and field; less
        their residuals over `measure`
    measure : (N, n) length of the line that belongs to a node [m]
    ahead : (m,) whether a field is taken from the left
    inner, outer : (m, N, n, n) derivatives of gradients to values in the own cell, and
        in that a field comes from
    """

    exchanged: Integers
    lower: Array
    own: Array
    upper: Array
    sources: Array
    measure: Array
    ahead: Flags
    inner: Array
    outer: Array

    @classmethod
    def zeros(
        cls,
        exchanged: Integers,
        measure: Array,
        ahead: Any,
        inner: Array,
        outer: Array,
    ) -> Blocks:
        """Return blocks to be added to."""
        m, k, (N, n) = len(ahead), len(exchanged), measure.shape
        lower, own, upper = (np.zeros((N, k, n, k, n)) for _ in range(3))
        return cls(
            exchanged,
            lower,
            own,
            upper,
            np.zeros((m, m, N, n)),
            measure,
            ahead,
            inner,
            outer,
        )

    @cached_property
    def place(self) -> dict[int, int]:
        """Place of each exchanged field in the blocks."""
        return {int(f): k for k, f in enumerate(self.exchanged)}

    def at_nodes(self, equations: Integers, fields: Integers) -> Array:
        """Return what equations (a,) take from fields (b,) by sources, at each node
        of all cells (n, N, a, b).
        """
        found: Array = (
            self.sources[equations][:, fields].transpose(3, 2, 0, 1)
            * -self.measure.T[:, :, None, None]
        )
        return found

    def of_exchanged(self) -> tuple[Array, Array, Array]:
        """Return lower, own and upper with all that was added to the sources."""
        own, nodes = self.own.copy(), np.arange(self.measure.shape[1])
        own[:, :, nodes, :, nodes] += self.at_nodes(self.exchanged, self.exchanged)
        return self.lower, own, self.upper

    def of_all(self) -> tuple[Array, Array, Array]:
        """Return the derivatives of the residuals of all equations to all fields,
        each (N, m, n, m, n).
        """
        (N, n), m, at = self.measure.shape, len(self.ahead), self.exchanged
        cells, nodes, fields = np.arange(N), np.arange(n), np.arange(m)
        found = [np.zeros((N, m, n, m, n)) for _ in range(3)]
        for out, block in zip(found, (self.lower, self.own, self.upper), strict=True):
            out[np.ix_(cells, at, nodes, at, nodes)] = block
        found[1][:, :, nodes, :, nodes] += self.at_nodes(fields, fields)
        return found[0], found[1], found[2]

    def add_nodes(self, e: int, f: int, slot: str, rows: Array) -> None:
        """Add derivatives (N, n, n) by values (slot "u") or gradients ("q") at the
        nodes of each cell.
        """
        row, column = self.place[e], self.place[f]
        if slot == "u":
            self.own[:, row, :, column, :] += rows
            return
        self.own[:, row, :, column, :] += rows @ self.inner[f]
        target = self.lower if self.ahead[f] else self.upper
        target[:, row, :, column, :] += rows @ self.outer[f]

    def add_trace(
        self, e: int, f: int, slot: str, factor: Array, trace: Array, shift: int
    ) -> None:
        """Add factor (N, n, 1) times the trace of a field (its value or its
        gradient) in the cell `shift` further.
        """
        targets = {-1: self.lower, 0: self.own, 1: self.upper}
        row, column = self.place[e], self.place[f]
        if slot == "u":
            targets[shift][:, row, :, column, :] += factor * trace
            return
        N = len(self.own)
        from_cell = np.clip(np.arange(N) + shift, 0, N - 1)
        targets[shift][:, row, :, column, :] += (
            factor * (trace @ self.inner[f][from_cell])[:, None, :]
        )
        beyond = shift + (-1 if self.ahead[f] else 1)
        part = factor * (trace @ self.outer[f][from_cell])[:, None, :]
        if part.any():
            targets[beyond][:, row, :, column, :] += part


def sparse(lower: Array, own: Array, upper: Array, numbers: Array) -> csc_matrix:
    """Return a block tridiagonal matrix of blocks (N, n, n), with the numbers (N, n)
    of the unknowns of each cell.
    """
    N, rows, columns, entries = len(own), [], [], []
    for block, shift in ((lower, -1), (own, 0), (upper, 1)):
        cells = np.arange(max(0, -shift), min(N, N - shift))
        cell, i, j = np.nonzero(block[cells])
        rows.append(numbers[cells[cell], i])
        columns.append(numbers[cells[cell] + shift, j])
        entries.append(block[cells[cell], i, j])
    where = np.concatenate(rows), np.concatenate(columns)
    shape = numbers.size, numbers.size
    return csc_matrix((np.concatenate(entries), where), shape)


class Factors:
    """LU factors of a block tridiagonal matrix, as a band or sparse.

    Parameters
    ----------
    blocks : what was added term by term
    sizes : typical values (m,) of residuals and of unknowns, over which entries are
        taken: pivots chosen by entries in watts and moles left 5e-4 of the sizes, where
        now 6e-8 is left, on the first cells of a bed of iron oxide

    Fields that are not exchanged are eliminated at each node first.

    Raises
    ------
    ConvergenceError : the matrix is singular or not finite
    """

    def __init__(self, blocks: Blocks, sizes: tuple[Array, Array]):
        self.residuals, self.unknowns = (each[:, None, None] for each in sizes)
        self.kept = blocks.exchanged
        self.local = np.setdiff1d(np.arange(len(blocks.ahead)), self.kept)
        over, by = sizes[0][self.kept], sizes[1][self.kept]
        lower, own, upper = (
            b * by[:, None] / over[:, None, None, None] for b in blocks.of_exchanged()
        )
        if len(self.local):
            self._condense(blocks, own, sizes)
        N, m, n = own.shape[:3]
        size = m * n
        lower, own, upper = (
            np.ascontiguousarray(b.transpose(0, 2, 1, 4, 3)).reshape(N, size, size)
            for b in (lower, own, upper)
        )
        self.shape, self._sparse = (N, m, n), None
        if size > WIDEST:
            self._sparse = self._sparse_factors(lower, own, upper)
            return
        width = 2 * size - 1
        band = np.zeros((3 * width + 1, N * size), order="F")
        for block, start in (
            (lower[1:], band[2 * width + size :]),
            (own, band[2 * width :]),
            (upper[:-1], band[2 * width - size :, size:]),
        ):
            # entry (i, j) of a block is i - j below the diagonal of column j
            entry, column = band.strides
            steps = (column * size, column - entry, entry)
            as_strided(start, block.shape, steps)[...] = block.transpose(0, 2, 1)
        if not np.isfinite(band).all():
            raise ConvergenceError("the matrix holds values that are not finite")
        self.width = width
        self.factors, self.pivots, info = dgbtrf(band, width, width, overwrite_ab=True)
        if info:
            raise ConvergenceError("the linear system is singular")

    @staticmethod
    def _sparse_factors(lower: Array, own: Array, upper: Array) -> Any:
        """Return the factors of blocks (N, size, size), most of whose entries are
        zero.
        """
        N, size = own.shape[:2]
        matrix = sparse(lower, own, upper, np.arange(N * size).reshape(N, size))
        if not np.isfinite(matrix.data).all():
            raise ConvergenceError("the matrix holds values that are not finite")
        try:
            return splu(matrix)
        except RuntimeError:
            raise ConvergenceError("the linear system is singular") from None

    def _condense(self, blocks: Blocks, own: Array, sizes: tuple[Array, Array]) -> None:
        """Take the eliminated fields out of the blocks `own` of the kept ones; keep
        what gives them at each node.
        """
        over, by = sizes[0], sizes[1]

        def part(rows: Any, columns: Any) -> Array:
            found: Array = blocks.at_nodes(rows, columns) * (
                by[columns] / over[rows][:, None]
            )
            return found

        kept, local, nodes = self.kept, self.local, np.arange(own.shape[2])
        try:
            self._inverse = np.linalg.inv(part(local, local))  # (node, N, local, local)
        except np.linalg.LinAlgError:
            raise ConvergenceError("the equations of a node are singular") from None
        by_kept = part(local, kept)
        self._onto = part(kept, local) @ self._inverse  # rows of kept fields
        self._by_kept = self._inverse @ by_kept
        own[:, :, nodes, :, nodes] -= self._onto @ by_kept

    def solve(self, residual: Array) -> Array:
        """Return the solution for a right-hand side (m, N, p + 1)."""
        found: Array = self._over_sizes(residual / self.residuals) * self.unknowns
        return found

    def _over_sizes(self, residual: Array) -> Array:
        if not len(self.local):
            return self._banded(residual)
        # (node, N, local, 1)
        of_local = residual[self.local].transpose(2, 1, 0)[..., None]
        out = np.empty_like(residual)
        right = residual[self.kept] - (self._onto @ of_local)[..., 0].transpose(2, 1, 0)
        out[self.kept] = self._banded(right)
        of_kept = out[self.kept].transpose(2, 1, 0)[..., None]
        found = self._inverse @ of_local - self._by_kept @ of_kept
        out[self.local] = found[..., 0].transpose(2, 1, 0)
        return out

    def _banded(self, residual: Array) -> Array:
        N, m, n = self.shape
        rhs = np.ascontiguousarray(residual.transpose(1, 2, 0)).ravel()
        if self._sparse is None:
            x = dgbtrs(self.factors, self.width, self.width, rhs, self.pivots)[0]
        else:
            x = self._sparse.solve(rhs)
        found: Array = x.reshape(N, n, m).transpose(2, 0, 1)
        return found
