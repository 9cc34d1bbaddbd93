"""Derivatives of the residuals of equations on a line: added term by term, kept as
blocks, solved with.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.fem.line_blocks import Blocks, Factors, sparse


class Slopes:
    """Derivatives of the residuals of a `line_dg.System`, see there for the
    equations.
    """

    def __init__(self, system: Any):
        self.system = system
        self.line = system.line
        self.ends = system.ends
        self.ahead = system.ahead
        line = self.line
        exchanged = np.setdiff1d(np.arange(system.m), system.local)
        measure = line.weights * line.h[:, None]
        self.blocks = Blocks.zeros(
            exchanged, measure, self.ahead, *self._of_gradients()
        )

    def matrix(self, sizes: Array) -> Any:
        """Return the sparse matrix of the derivatives of residuals over sizes (m,),
        both as they are stored.
        """
        m, (N, n) = self.system.m, self.blocks.measure.shape
        numbers = np.arange(m * N * n).reshape(m, N, n).transpose(1, 0, 2)
        lower, own, upper = (
            (block / sizes[:, None, None, None]).reshape(N, m * n, m * n)
            for block in self.blocks.of_all()
        )
        return sparse(lower, own, upper, numbers.reshape(N, m * n))

    def factors(self, residuals: Array, unknowns: Array) -> Factors:
        """Return the factors, to solve with, from typical values (m,) of residuals
        and unknowns.
        """
        return Factors(self.blocks, (residuals, unknowns))

    def add_flux(self, e: int, f: int, slot: str, t: Array) -> None:
        """Add the derivative (N, p + 1) of the flux of an equation by the value
        ("u") or gradient ("q") of a field.
        """
        line = self.line
        test = line.weights[:, None] * line.slopes
        self.blocks.add_nodes(e, f, slot, -test.T[None] * t[:, None, :])  # (N, i, a)

    def add_source(self, e: int, f: int, slot: str, t: Array) -> None:
        """Add the derivative (N, p + 1) of the source of an equation by the value or
        gradient of a field.
        """
        if slot == "u":
            self.blocks.sources[e, f] += t
            return
        N, n = t.shape
        rows = np.zeros((N, n, n))
        rows[:, range(n), range(n)] = -t * self.blocks.measure
        self.blocks.add_nodes(e, f, slot, rows)

    def add_coupling(self, coupling: Array) -> None:
        """Add derivatives (m, m) of the sources of equations by the values of
        fields, alike at all nodes.
        """
        self.blocks.sources[...] += coupling[:, :, None, None]

    def add_damping(self, e: int, f: int, t: Array) -> None:
        """Add the derivative (N, p + 1) of the flux of an equation by the slope of a
        field over its cell.
        """
        D = self.line.slopes
        self.blocks.add_nodes(
            e, f, "u", -D.T @ ((self.line.weights * t)[:, :, None] * D)
        )

    def add_face(self, e: int, f: int, slot: str, t: Array, left_side: bool) -> None:
        """Add d(flux)/d(trace) `t` (N + 1,) of one field, whose trace belongs to the
        cell on one side of each face.
        """
        line, N, blocks = self.line, self.line.cells, self.blocks
        cells = np.arange(N)
        for side, k, sign, phi in (
            ("right", cells + 1, 1.0, line.right),
            ("left", cells, -1.0, line.left),
        ):
            # the face `side` of every cell c; its trace belongs to c itself or to a
            # neighbour
            neighbour = (side == "right" and not left_side) or (
                side == "left" and left_side
            )
            at_end = (k == N) if side == "right" else (k == 0)
            trace = line.right if left_side else line.left
            prescribed = np.isfinite(self.ends.value[1 if side == "right" else 0][f])
            coefficient = sign * t[k]
            if not neighbour:
                blocks.add_trace(
                    e,
                    f,
                    slot,
                    coefficient[:, None, None] * phi[None, :, None],
                    trace,
                    0,
                )
                continue
            factor = (
                np.where(at_end, 0.0, coefficient)[:, None, None] * phi[None, :, None]
            )
            blocks.add_trace(e, f, slot, factor, trace, 1 if side == "right" else -1)
            comes_in = (side == "left") == bool(self.ahead[f])
            if not (prescribed and comes_in and slot == "u"):
                factor = (
                    np.where(at_end, coefficient, 0.0)[:, None, None]
                    * phi[None, :, None]
                )
                blocks.add_trace(e, f, slot, factor, phi, 0)

    def _of_gradients(self) -> tuple[Array, Array]:
        """Return derivatives of gradients (m, N, n, n) to values in the own cell and
        in that a field comes from.
        """
        line, n, N = self.line, self.line.degree + 1, self.line.cells
        inner, outer = (np.zeros((self.system.m, N, n, n)) for _ in range(2))
        for f in np.flatnonzero(self.system.diffuses):
            ahead = self.ahead[f]
            end, opposite = (
                (line.left, line.right) if ahead else (line.right, line.left)
            )
            sign = 1.0 if ahead else -1.0
            own_lift = sign * np.outer(end / line.weights, end)
            lifts = np.ones(N)
            edge = 0 if ahead else N - 1
            if not np.isfinite(self.ends.value[0 if ahead else 1][f]):
                lifts[edge] = 0.0
            inner[f] = (line.slopes[None] + lifts[:, None, None] * own_lift) / line.h[
                :, None, None
            ]
            lifts[edge] = 0.0
            outer[f] = (
                lifts[:, None, None]
                * (-sign * np.outer(end / line.weights, opposite))
                / line.h[:, None, None]
            )
        return inner, outer
