"""One solid phase of a reacting bed: what its particles hold, and how fast they
move.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.particle.adsorption import Inside
from contbed.reacting_bed.equations.unknowns import LEAST_T, PhaseLayout, State

Enthalpy = Callable[[Any], Any]


@dataclass(frozen=True, eq=False)
class Phase:
    """A solid phase.

    medium : gives its exchange, conductivity and films, see `medium.PhaseMedium`
    enthalpies : of gases and of its constituents by name
    velocity : true velocity [m/s]
    inert : amount [per m3 bed] and enthalpy of what does not react
    inside : its particles, where they take up gas
    """

    layout: PhaseLayout
    medium: Any
    enthalpies: Mapping[str, Enthalpy]
    velocity: float
    inert: tuple[tuple[float, Enthalpy], ...]
    inside: Inside | None = None

    def enthalpy(self, state: State) -> Any:
        """Return the enthalpy of the particles [J/m3 bed]."""
        T = state.T_solid
        total: Any = sum(n * self.enthalpies[name](T) for name, n in state.n.items())
        if self.inside is not None:
            held, heat = self.inside.held(state.inner, np.maximum(T, LEAST_T))
            total = (
                total
                + heat
                + sum(
                    sum(points) * self.enthalpies[name](T)
                    for name, points in held.items()
                )
            )
        return total + sum(n * h(T) for n, h in self.inert)

    @property
    def stores_heat(self) -> bool:
        """Whether constituents with data hold heat."""
        return bool(self.inert or self.layout.solids)

    def moles_inside(self, state: State) -> list[Any]:
        """Return the moles that each point of particles holds of each gas, as the
        unknowns are ordered [mol/m3 bed].
        """
        if self.inside is None:
            return []
        held = self.inside.held(state.inner, np.maximum(state.T_solid, LEAST_T))[0]
        return [moles for points in held.values() for moles in points]

    def diffusion_inside(self) -> Array | None:
        """Return the sources that are linear in the unknowns inside (a, a); None
        without several points.
        """
        if self.inside is None or self.layout.points == 1:
            return None
        points, gases = self.layout.points, self.layout.inside
        out = np.zeros((points * len(gases), points * len(gases)))
        for k, gas in enumerate(gases):
            here = slice(k * points, (k + 1) * points)
            out[here, here] = self.inside.conduction(gas)
        return out
