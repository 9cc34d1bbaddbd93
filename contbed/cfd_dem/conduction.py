"""Conduction between particles in a gas: through contacts at rest and in impacts, and
through the gas between them.

Contacts younger than the duration of an impact conduct as impacts (Eq. 7 of Zhou, Hou
and Yu 2011), older ones as contacts at rest (Eq. 6, Batchelor and O'Brien); the gas
between particles carries heat by Eq. 5. All of it is corrected for particles that are
softer than real ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contbed.arrays import Array
from contbed.cfd_dem.gas_quantities import Local
from contbed.dem import heat, heat_impact
from contbed.dem.heat_pair import IMPACT, STATIC, correction
from contbed.dem.particles import pair_table
from contbed.dem.simulation import Simulation


@dataclass(frozen=True)
class Solid:
    """How particles conduct to each other.

    Parameters
    ----------
    conductivity [W/m/K]
    heat_capacity [J/kg/K]
    modulus [Pa] : Young's modulus of the real material; None, or that of the
        simulation, for no correction
    exponents : of the correction of contacts at rest and of impacts; (1/5, 1/5) as in
        the paper
    """

    conductivity: float
    heat_capacity: float = 840.0
    modulus: float | None = None
    exponents: tuple[float, float] = (STATIC, IMPACT)

    def exchange(
        self, simulation: Simulation, around: Local
    ) -> tuple[heat.Pairs, dict[str, Array]]:
        """Find the pairs of particles within 1.5 diameters and their
        conductances [W/K].

        Mechanisms: `contact` and `impact` through closed contacts, `fluid_touching`,
            `fluid_apart` through the gas.
        """
        x, radius = simulation.position, simulation.radius
        equal = np.ptp(radius) == 0.0
        domain = simulation.domain
        lower, upper = np.array(domain.lower, float), np.array(domain.upper, float)
        widest = heat.VIEW * 2.0 * float(radius.max())
        pairs = heat.near_pairs(x, widest, (lower, upper), domain.periodic)
        if self.conductivity == 0.0:
            return pairs, {}
        soft = simulation.materials[0].youngs_modulus
        static, hit = (
            correction(soft, self.modulus or soft, exponent)
            for exponent in self.exponents
        )
        how = heat.Conduction(
            self.conductivity, float(around.k.mean()), around.eps, float(static)
        )
        parts = heat.conductances(pairs, radius[0] if equal else radius, how)
        return pairs, self._impacts(simulation, pairs, parts, float(hit))

    def _impacts(
        self,
        simulation: Simulation,
        pairs: heat.Pairs,
        parts: dict[str, Array],
        factor: float,
    ) -> dict[str, Array]:
        """Move contacts younger than an impact lasts to the mechanism `impact`."""
        contacts = simulation.contacts()
        n = len(simulation.position)
        parts = parts | {"impact": np.zeros(len(pairs.i))}
        fresh = contacts.impact_speed > 0.0
        if not fresh.any():
            return parts
        i, j, speed = contacts.i[fresh], contacts.j[fresh], contacts.impact_speed[fresh]
        age = simulation.time - contacts.since[fresh]
        R, m = simulation.radius, simulation.mass
        modulus = pair_table(simulation.materials)["youngs_modulus"][
            simulation.kind[i], simulation.kind[j]
        ]
        impact = heat_impact.hertz_impact(
            R[i] * R[j] / (R[i] + R[j]), m[i] * m[j] / (m[i] + m[j]), modulus, speed
        )
        hits = age < impact.duration
        density = np.array([material.density for material in simulation.materials])[
            simulation.kind
        ]
        store = density * self.heat_capacity
        k = self.conductivity
        G = heat_impact.impact_conductance(impact, (k, k), (store[i], store[j]), factor)
        # of the pairs, those that collide; the small index comes first in both
        key = np.minimum(pairs.i, pairs.j) * n + np.maximum(pairs.i, pairs.j)
        order = np.argsort(key, kind="stable")
        wanted = (np.minimum(i, j) * n + np.maximum(i, j))[hits]
        found = np.minimum(np.searchsorted(key[order], wanted), len(key) - 1)
        where = order[found]
        same = key[where] == wanted
        contact, hit = parts["contact"].copy(), parts["impact"]
        hit[where[same]], contact[where[same]] = G[hits][same], 0.0
        return parts | {"contact": contact}
