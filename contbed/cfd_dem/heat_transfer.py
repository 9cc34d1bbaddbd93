"""Heat transfer coefficients of particles, by mechanism.

h_i = (h_convection A_i + sum over j of G_ij)/A_i: what particle i loses per area and
kelvin when it is hotter than a bed and a gas of one temperature. Conduction is that of
`conduction`, radiation that of Eqs. 8-9 of Zhou, Hou and Yu 2011 at small differences
of temperature.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from contbed.arrays import Array
from contbed.cfd_dem.conduction import Solid
from contbed.cfd_dem.coupling import Bed
from contbed.compiled.interrupts import deferred_interrupt
from contbed.dem import heat
from contbed.dem.sizes import sauter_mean


def coefficients(
    bed: Bed, solid: Solid, emissivity: float = 0.0, T: float = 300.0
) -> dict[str, Array]:
    """Evaluate the coefficients of all particles by mechanism [W/m2/K], (n,);
    `T` [K] is that of radiation. None without a Nusselt number.
    """
    if bed.gas.nusselt is None:
        return {}
    simulation, around = bed.simulation, bed.gas.around(bed.motion)
    n, d_p = len(simulation.position), 2.0 * simulation.radius
    pairs, parts = solid.exchange(simulation, around)
    if emissivity > 0.0:
        parts["radiation"] = heat.radiation_conductance(
            pairs, n, T, float(d_p.mean()), emissivity, around.eps
        )
    area = np.pi * d_p**2
    found = {
        name: (np.bincount(pairs.i, part, n) + np.bincount(pairs.j, part, n)) / area
        for name, part in parts.items()
    }
    return {"convection": bed.gas.convection(around, d_p)} | found


class Average:
    """Time average of the coefficients of every particle: call it with a bed at even
    intervals.

    `mean` maps mechanisms to (n,) [W/m2/K], `coordination` is the mean number of
    touching neighbours; `Re`, `eps` are those at the particles (n,), `Pr` their mean,
    averaged over the calls. Radiation is that at the mean temperature of the particles,
    `T` [K] where they have none.
    """

    def __init__(self, solid: Solid, emissivity: float = 0.0, T: float = 300.0):
        self.solid, self.emissivity, self.T = solid, emissivity, T
        self.mean: dict[str, Array] = {}
        self.count, self.coordination = 0, 0.0
        self.Re: Array = np.zeros(0)
        self.eps: Array = np.zeros(0)
        self.Pr = 0.0

    def state(self) -> dict[str, Array]:
        """Return the averages as arrays for a checkpoint."""
        arrays = {f"mean_{name}": value for name, value in self.mean.items()}
        numbers = np.array([self.count, self.coordination, self.Pr])
        return arrays | {"numbers": numbers, "Re": self.Re, "eps": self.eps}

    def restore(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays of `state`."""
        count, self.coordination, self.Pr = state["numbers"].tolist()
        self.count, self.Re, self.eps = int(count), state["Re"], state["eps"]
        self.mean = {
            name[5:]: value for name, value in state.items() if name.startswith("mean_")
        }

    @deferred_interrupt()
    def __call__(self, bed: Bed) -> None:
        """Take the bed as it is now into the average."""
        T = self.T if bed.T is None else float(bed.T.mean())
        found = coefficients(bed, self.solid, self.emissivity, T)
        around = bed.gas.around(bed.motion)
        z = 2.0 * len(bed.simulation.contacts()) / len(bed.simulation.position)
        old = self.count / (self.count + 1.0)
        self.count += 1
        new = 1.0 - old
        for name, h in found.items():
            self.mean[name] = (
                old * self.mean[name] + new * h if name in self.mean else h
            )
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
        """Average over all particles, by mechanism [W/m2/K]."""
        return {name: float(h.mean()) for name, h in self.mean.items()}


def bed_nusselt(
    bed: Bed, velocity: float, T: float, solid: Solid, of: str = "convection"
) -> tuple[float, float, float]:
    """Find Re and Pr of a superficial velocity [m/s] through a bed at rest, and Nu of
    its mean coefficient.

    The gas enters at T [K], that of the bed, and has crossed the grid once. `of`
    "total" adds what `solid` conducts. The length of both numbers is the Sauter mean
    diameter, the coefficient the mean over the surface: with them a bed of one size
    exchanges what the particles of all sizes do.
    """
    gas, grid, d_p = bed.gas, bed.gas.grid, 2.0 * bed.simulation.radius
    gas.inlet(velocity, T)
    bed.run(float(grid.size[2] * grid.count[2]) / velocity)
    average = Average(solid)
    average(bed)
    h = average.mean["convection"] if of == "convection" else average.total
    rho, mu, k, c = (
        float(getattr(gas.fluid, name)(T))
        for name in ("density", "viscosity", "conductivity", "heat_capacity")
    )
    d_32, surface = sauter_mean(d_p), d_p**2
    return (
        rho * velocity * d_32 / mu,
        mu * c / k,
        float((h * surface).sum() / surface.sum()) * d_32 / k,
    )
