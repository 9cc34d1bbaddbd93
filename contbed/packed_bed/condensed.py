"""What is condensed of the particles of a line at rest: their modes at its nodes,
and the bed that sees one of them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contbed.fem.ad.dual import plain
from contbed.packed_bed.equations import two_energy
from contbed.solvers.condensed import Inside


def condensed(problem: Any) -> Inside:
    """Return the modes of a heat problem with constant properties whose solids rest."""
    c, T = problem.coefficients, problem.medium.T_fluid_in
    system = problem.system
    places = [
        system.offset[name, 0] + np.arange(system.fields[name][0].size)
        for name in two_energy.FIELDS
    ]
    return Inside(
        bed=OneMode(problem),
        capacity=float(c.capacity(T) * c.solid.heat_capacity(T)),
        exchange=float(plain(c.exchange(T, T))),
        decay=np.array([float(mode.decay(T)) for mode in c.modes]),
        gain=np.array([mode.gain for mode in c.modes]),
        fluid=places[0],
        solid=places[1],
    )


class OneMode:
    """A heat problem with the first mode of its particles in place of all: what the
    bed sees of them.
    """

    linear = True

    def __init__(self, problem: Any):
        self._problem = problem
        one = replace(problem.coefficients, modes=problem.coefficients.modes[:1])
        cells = problem.system.cells
        self._interior, self._storage = (
            [(two_energy.residual, cells, one)],
            [(two_energy.storage, cells, one)],
        )
        self.fixed, self.weights, self.changes = (
            problem.fixed,
            problem.weights,
            problem.changes,
        )

    @property
    def fixed_values(self) -> Any:
        """Prescribed temperatures at the time of the last `at` [K]."""
        return self._problem.fixed_values

    def at(self, time: float) -> None:
        """Put the temperatures and fluxes of boundaries at a time [s] in place."""
        self._problem.at(time)

    def shares(self, time: float) -> Any:
        """Return how far the boundaries have come at a time [s] to other values."""
        return self._problem.shares(time)

    def put(self, shares: Any) -> None:
        """Put temperatures and fluxes of boundaries in place that have come so far
        to other values.
        """
        self._problem.put(shares)

    def steady(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Assemble the residual of the steady balances and its Jacobian."""
        found: tuple[Any, Any] = self._problem.system.assemble(
            [*self._interior, *self._problem.crossed()], state, jacobian
        )
        return found

    def content(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Assemble the tested heat content and its Jacobian."""
        found: tuple[Any, Any] = self._problem.system.assemble(
            self._storage, state, jacobian
        )
        return found
