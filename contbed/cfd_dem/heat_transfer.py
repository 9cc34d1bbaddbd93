"""Heat transfer coefficients of particles, by mechanism.

h_i = (h_convection A_i + sum over j of G_ij)/A_i: what particle i loses per area and kelvin when it is hotter than a
bed and a gas of one temperature. Contacts younger than the duration of an impact conduct as impacts (Eq. 7 of Zhou,
Hou and Yu 2011), older ones as contacts at rest (Eq. 6); the fluid between particles carries heat by Eq. 5, radiation
by Eqs. 8-9 at small differences of temperature. All of it is corrected for particles that are softer than real ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from contbed.dem import heat, heat_impact
from contbed.dem.heat_pair import IMPACT, STATIC, correction
from contbed.dem.particles import pair_table
from contbed.dem.simulation import Simulation

if TYPE_CHECKING:
    from contbed.cfd_dem.coupling import Bed
    from contbed.cfd_dem.gas import Local

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Solid:
    """How particles conduct to each other.

    Parameters
    ----------
    conductivity [W/m/K]
    heat_capacity [J/kg/K]
    modulus [Pa] : Young's modulus of the real material; None, or that of the simulation, for no correction
    exponents : of the correction of contacts at rest and of impacts; (1/5, 1/5) as in the paper
    """

    conductivity: float
    heat_capacity: float = 840.0
    modulus: float | None = None
    exponents: tuple[float, float] = (STATIC, IMPACT)

    def exchange(self, simulation: Simulation, around: Local) -> tuple[heat.Pairs, dict[str, Array]]:
        """Pairs of particles within 1.5 diameters and their conductances [W/K].

        Mechanisms: `contact` and `impact` through closed contacts, `fluid_touching`, `fluid_apart` through the gas.
        """
        x, radius = simulation.position, simulation.radius
        equal = np.ptp(radius) == 0.0
        box = tuple(np.array(corner, dtype=float) for corner in (simulation.domain.lower, simulation.domain.upper))
        pairs = heat.near_pairs(x, heat.VIEW * 2.0 * float(radius.max()), box, simulation.domain.periodic)  # type: ignore[arg-type]
        if self.conductivity == 0.0:
            return pairs, {}
        soft = simulation.materials[0].youngs_modulus
        static, hit = (correction(soft, self.modulus or soft, exponent) for exponent in self.exponents)
        how = heat.Conduction(self.conductivity, float(around.k.mean()), around.eps, float(static))
        parts = heat.conductances(pairs, radius[0] if equal else radius, how)
        return pairs, self._impacts(simulation, pairs, parts, float(hit))

    def _impacts(
        self, simulation: Simulation, pairs: heat.Pairs, parts: dict[str, Array], factor: float
    ) -> dict[str, Array]:
        """Contacts younger than an impact lasts are impacts."""
        contacts = simulation.contacts()
        n = len(simulation.position)
        parts = parts | {"impact": np.zeros(len(pairs.i))}
        fresh = contacts.impact_speed > 0.0
        if not fresh.any():
            return parts
        i, j, speed = contacts.i[fresh], contacts.j[fresh], contacts.impact_speed[fresh]
        age = simulation.time - contacts.since[fresh]
        R, m = simulation.radius, simulation.mass
        modulus = pair_table(simulation.materials)["youngs_modulus"][simulation.kind[i], simulation.kind[j]]
        impact = heat_impact.hertz_impact(R[i] * R[j] / (R[i] + R[j]), m[i] * m[j] / (m[i] + m[j]), modulus, speed)
        hits = heat_impact.colliding(age, impact.duration)
        density = np.array([material.density for material in simulation.materials])[simulation.kind]
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


def coefficients(bed: Bed, solid: Solid, emissivity: float = 0.0, T: float = 300.0) -> dict[str, Array]:
    """Coefficient of every particle by mechanism [W/m2/K], (n,), as the bed is now; `T` [K] is that of radiation."""
    simulation, around = bed.simulation, bed.gas.around(bed.motion)
    n, d_p = len(simulation.position), 2.0 * simulation.radius
    pairs, parts = solid.exchange(simulation, around)
    if emissivity > 0.0:
        parts["radiation"] = heat.radiation_conductance(pairs, n, T, float(d_p.mean()), emissivity, around.eps)
    area = np.pi * d_p**2
    found = {
        name: (np.bincount(pairs.i, part, n) + np.bincount(pairs.j, part, n)) / area for name, part in parts.items()
    }
    return {"convection": bed.gas.convection(around, d_p)} | found


class Average:
    """Time average of the coefficients of every particle: call it with a bed at even intervals.

    `mean` maps mechanisms to (n,) [W/m2/K], `coordination` is the mean number of touching neighbours; `Re`, `eps` are
    those at the particles (n,), `Pr` their mean, averaged over the calls.
    """

    def __init__(self, solid: Solid, emissivity: float = 0.0, T: float = 300.0):
        self.solid, self.emissivity, self.T = solid, emissivity, T
        self.mean: dict[str, Array] = {}
        self.count, self.coordination = 0, 0.0
        self.Re: Array = np.zeros(0)
        self.eps: Array = np.zeros(0)
        self.Pr = 0.0

    def __call__(self, bed: Bed) -> None:
        found = coefficients(bed, self.solid, self.emissivity, self.T)
        around, z = bed.gas.around(bed.motion), 2.0 * len(bed.simulation.contacts()) / len(bed.simulation.position)
        old = self.count / (self.count + 1.0)
        self.count += 1
        new = 1.0 - old
        for name, h in found.items():
            self.mean[name] = old * self.mean[name] + new * h if name in self.mean else h
        self.coordination = old * self.coordination + new * z
        self.Re, self.eps = (
            new * now + (old * past if len(past) else 0.0)
            for past, now in ((self.Re, around.Re), (self.eps, around.eps))
        )
        self.Pr = old * self.Pr + new * float(around.Pr.mean())

    @property
    def total(self) -> Array:
        """Sum of the mechanisms for every particle [W/m2/K]."""
        return heat.total(self.mean)

    def bed_means(self) -> dict[str, float]:
        """Averages over all particles by mechanism [W/m2/K]."""
        return {name: float(h.mean()) for name, h in self.mean.items()}


def bed_nusselt(
    bed: Bed, velocity: float, T: float, solid: Solid, of: str = "convection"
) -> tuple[float, float, float]:
    """Re and Pr of a superficial velocity [m/s] through a bed at rest, and Nu of the mean coefficient of its particles.

    The gas enters at T [K], that of the bed, and has crossed the grid once. `of` "total" adds what `solid` conducts.
    """
    gas, grid, d_p = bed.gas, bed.gas.grid, 2.0 * bed.simulation.radius
    gas.inlet(velocity, T)
    bed.run(float(grid.size[2] * grid.count[2]) / velocity)
    average = Average(solid)
    average(bed)
    h = average.mean["convection"] if of == "convection" else average.total
    rho, mu, k, c = (
        float(getattr(gas.fluid, name)(T)) for name in ("density", "viscosity", "conductivity", "heat_capacity")
    )
    return rho * velocity * float(d_p.mean()) / mu, mu * c / k, float((h * d_p).mean()) / k
