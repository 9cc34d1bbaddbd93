"""What a reacting bed holds in time, added to the residuals of its steady equations:
implicit Euler steps.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array
from contbed.fem.ad.dual import Dual
from contbed.reacting_bed.equations.bed import Bed
from contbed.reacting_bed.equations.unknowns import Role
from contbed.reacting_bed.problem import Problem

# [J/m3/K], heat capacity of a bed in marches whose particles have no data
NO_DATA = 1e6


def stored_rows(problem: Problem) -> NDArray[np.intp]:
    """Return the rows of the unknowns that store something in time; the others
    follow at once.
    """
    fills = problem.bed.gas_pressure is not None
    stored = {Role.SOLID, Role.POINT, Role.T, Role.T_SOLID}
    if fills:
        stored |= {Role.GAS, Role.T_GAS}
    return problem.rows(*stored)


def gas_of_rings(problem: Problem) -> tuple[NDArray[np.intp], ...]:
    """Return the rows of the gases of each ring, one ring in one dimension."""
    return tuple(np.split(problem.rows(Role.GAS), problem.ring_count))


def content(problem: Problem, u: Array) -> Array:
    """Return the content of a state per volume of bed by equation, (m, N, p + 1)."""
    return Storage(problem, u, 1.0).content(u, False)[0]


class Storage:
    """What particles, and where asked for the gas, hold: implicit Euler steps for
    marches to a steady state.
    """

    def __init__(self, problem: Problem, held: Array, dt: float, loose: bool = True):
        self.problem, self.dt, self.held, self.loose = problem, dt, held, loose

    @classmethod
    def after(cls, problem: Problem, before: Array, dt: float) -> Storage:
        """Return the storage of an implicit Euler step from a state."""
        return cls(problem, content(problem, before), dt)

    def content(self, u: Array, jacobian: bool) -> tuple[Array, Any]:
        """Return the content per volume of bed by equation at the nodes, and its
        derivatives.
        """
        flat, section = u.reshape(len(u), -1), self.problem.section
        one = np.ones(flat.shape[1])
        values: list[Any] = (
            [Dual(x, {("u", k): one}) for k, x in enumerate(flat)]
            if jacobian
            else list(flat)
        )
        parts = (
            self._of_bed(values)
            if section is None
            else section.held(values, self._of_bed)
        )
        table = np.empty_like(flat)
        for row, part in zip(table, parts, strict=True):
            row[:] = getattr(part, "value", part)
        return table.reshape(u.shape), parts

    def _of_bed(self, values: list[Any]) -> list[Any]:
        """Return the content by equation of the layout at points."""
        bed = self.bed_at(values)
        state = bed.state(values)
        parts: list[Any] = [0.0] * len(bed.layout.names)
        gas, heat = (
            bed.held_by_gas(state) if bed.gas_pressure is not None else ({}, 0.0)
        )
        inside = iter(
            [
                moles
                for phase, own in bed.with_states(state)
                for moles in phase.moles_inside(own)
            ]
        )
        for k, (_, role, species, phase) in enumerate(bed.layout.unknowns):
            if role is Role.SOLID:
                parts[k] = values[k]
            elif role is Role.GAS and species in gas:
                parts[k] = gas[species]
            elif role is Role.POINT:
                parts[k] = next(inside)
            elif role is Role.T_GAS:
                parts[k] = heat
            elif role in (Role.T, Role.T_SOLID):
                of_solids = bed.heat_of_solids(state, phase)
                parts[k] = NO_DATA * values[k]
                if of_solids is not None:
                    parts[k] = of_solids + (heat if role is Role.T else 0.0)
        return parts

    def bed_at(self, _: list[Any]) -> Bed:
        """Return the bed whose gas is stored at the pressure of values of the
        unknowns.
        """
        return self.problem.bed

    def residual(self, u: Array) -> Array:
        """Return what storage adds to the residuals."""
        weight = self.problem.line.weights * self.problem.line.h[:, None] / self.dt
        found: Array = (self.content(u, False)[0] - self.held) * weight
        return found

    def rounding(self) -> Array:
        """Return what one rounding of all terms is in the residuals: of the content,
        over the step, and of fluxes.
        """
        line, sizes = self.problem.line, self.problem.flux_sizes[:, None, None]
        found: Array = np.finfo(float).eps * (
            np.abs(self.held) * line.weights * line.h[:, None] / self.dt + sizes
        )
        return found

    def add(self, u: Array, residual: Array, slopes: Any) -> Array:
        """Return the residuals with what storage adds, and add its derivatives to
        theirs.
        """
        line = self.problem.line
        _, N, n = u.shape
        held, parts = self.content(u, True)
        for e, part in enumerate(parts):
            for (_, f), tangent in getattr(part, "tangents", {}).items():
                slopes.add_source(
                    e,
                    f,
                    "u",
                    np.broadcast_to(-tangent / self.dt, (N * n,)).reshape(N, n),
                )
        return residual + (held - self.held) * (
            line.weights * line.h[:, None] / self.dt
        )
