"""Velocity, density and pressure along a bed in plug flow, from the temperature of the fluid.

The mass flux G is what the scene gives, at the density of the inlet, and is the same all along; so u = G/rho(T), and

    dp/dx = -(mu/K + rho c_F/sqrt(K) |w|) w - d(G u/eps^2)/dx,      w = u - u_solid

with the properties at the local temperature: Darcy and Forchheimer's resistance, and the momentum that a fluid gains
as it expands. p [Pa] is the pressure of the fluid over that at the outlet.

Source: Nield & Bejan 2017, Convection in Porous Media, 5th ed., Eqs. 1.12 and 1.15, doi:10.1007/978-3-319-49562-0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.packed_bed.medium import Medium

Array = NDArray[np.float64]


class Stream(NamedTuple):
    """Superficial velocity [m/s], density [kg/m3] and pressure [Pa] of the fluid at points along a bed."""

    u: Array
    density: Array
    pressure: Array


def along_bed(medium: Medium, x: Array, T: Array, velocity: float, velocity_solid: float) -> Stream:
    """Integrate the pressure gradient along a bed.

    Parameters
    ----------
    medium : closures and properties
    x : coordinate along the bed [m] (n,), increasing
    T : temperature of the fluid there [K] (n,)
    velocity, velocity_solid : superficial, along x, that of the fluid at the density of the inlet [m/s]

    Returns
    -------
    Stream of arrays (n,); the pressure is zero where the fluid leaves. The trapezoidal rule is used between the points.
    """
    porosity, permeability = medium.scene.bed.porosity, medium.packing("permeability")
    density = np.broadcast_to(np.asarray(medium.fluid.density(T), dtype=float), T.shape)
    viscosity = np.broadcast_to(np.asarray(medium.fluid.viscosity(T), dtype=float), T.shape)
    flux = medium.mass_flux_scale() * velocity
    u = flux / density
    w = u - velocity_solid
    resistance = viscosity / permeability + density * medium.packing("forchheimer") / permeability**0.5 * np.abs(w)
    gradient = -resistance * w
    risen = np.concatenate(([0.0], np.cumsum(0.5 * (gradient[1:] + gradient[:-1]) * np.diff(x))))
    pressure = risen - flux * u / porosity**2
    return Stream(u, density, pressure - pressure[-1 if velocity >= 0 else 0])
