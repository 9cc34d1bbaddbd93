"""Velocity, density and pressure along a bed in plug flow, from the temperature of the
fluid.

The mass flux G is what the scene gives, at the density of the inlet, and is the same
all along; so u = G/rho(T), and

    dp/dx = -(mu/K + rho c_F/sqrt(K) |w|) w - d(G u/eps^2)/dx,      w = u - u_0
    u_0: velocity of a fluid that moves with the particles, see `Medium.comoving`
    |w|: speed in all directions, of streams that cross the bed as well

with the properties at the local temperature: Darcy and Forchheimer's resistance, and
the momentum that a fluid gains as it expands. p [Pa] is the pressure of the fluid over
that at the outlet.

Source: Nield & Bejan 2017, Convection in Porous Media, 5th ed., Eqs. 1.12 and 1.15,
    doi:10.1007/978-3-319-49562-0.

A fluid that flows upwards carries the bed, and fluidizes it, where its pressure
gradient exceeds the weight of the particles less their buoyancy, (1 - eps)
(rho_s - rho) g (Ergun 1952, Chem. Eng. Prog. 48, 89-94).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contbed.arrays import Array
from contbed.packed_bed.inlets import velocity_key
from contbed.scene.gas import GasConstant
from contbed.scene.toml_lines import parse_key

GRAVITY = 9.81  # m/s2
# change of the density by the drop, over itself: the drop is wrong by half as much, 2 %
COMPRESSED = 0.04
# change of the speed of fronts by the expansion of a fluid, and temperatures over which
# it is summed
EXPANDED, BETWEEN = 0.01, 65


class Stream(NamedTuple):
    """Superficial velocity [m/s], density [kg/m3] and pressure [Pa] of the fluid at
    points along a bed.
    """

    u: Array
    density: Array
    pressure: Array


def along_bed(plan: Any, x: Array, T: Array) -> Stream:
    """Integrate the pressure gradient along the bed of a plan.

    Parameters
    ----------
    x : coordinate along the bed, see `direction` [m] (n,), increasing
    T : temperature of the fluid there [K] (n,)

    Returns
    -------
    Stream of arrays (n,); the pressure is zero where the fluid leaves. The trapezoidal rule is used between the points.
    """
    velocity, density, drag = resistance(plan, T)
    way = direction(plan)
    u, gradient = way @ velocity, way @ drag
    risen = np.concatenate(
        ([0.0], np.cumsum(0.5 * (gradient[1:] + gradient[:-1]) * np.diff(x)))
    )
    pressure = risen - density * u**2 / plan.scene.packed_bed.porosity**2
    outlet = -1 if way @ plan.velocity >= 0 else 0
    return Stream(u, density, pressure - pressure[outlet])


def direction(plan: Any) -> Array:
    """Return the unit vector of the way along the bed: its axis, or that of the flow
    through a tilted bed.
    """
    tilted = is_tilted(plan)
    way = plan.velocity if tilted else np.eye(len(plan.velocity))[plan.mesh.axis]
    found: Array = way / np.linalg.norm(way)
    return found


def along_way(plan: Any) -> float:
    """Return the length of the bed in its `direction` [m]."""
    return float(np.ptp(direction(plan) @ plan.mesh.skfem.p))


def is_tilted(plan: Any) -> bool:
    """Return whether the fluid flows from plane to plane at an angle to the axes of the
    mesh.
    """
    if np.count_nonzero(plan.velocity) < 2:
        return False
    from contbed.packed_bed.curved_inlet import PARALLEL
    from contbed.packed_bed.flow import is_across

    sizes = np.abs(plan.velocity)
    if np.count_nonzero(sizes > PARALLEL * sizes.max()) < 2:
        return False
    ends = [name for name, kind in plan.roles.items() if kind in ("inlet", "outlet")]
    return all(is_across(plan.mesh, name, plan.velocity) for name in ends)


def resistance(plan: Any, T: Array) -> tuple[Array, Array, Array]:
    """Return velocity [m/s] (dim, n), density [kg/m3] (n,) and the pressure gradient
    by drag [Pa/m] (dim, n) at temperatures (n,).
    """
    medium = plan.medium
    permeability = medium.packing("permeability")
    density = np.broadcast_to(medium.fluid.density(T), T.shape)
    viscosity = np.broadcast_to(medium.fluid.viscosity(T), T.shape)
    u = medium.mass_flux_scale() * plan.velocity[:, None] / density
    w = u - medium.comoving(plan.velocity_solid)[:, None]
    speed = np.sqrt(np.sum(w**2, axis=0))
    drag = (
        viscosity / permeability
        + density * medium.packing("forchheimer") / permeability**0.5 * speed
    )
    return u, density, -drag * w


def compressed(plan: Any, drop: float) -> str:
    """Return a warning where the density changes much by the pressure drop [Pa]; empty
    where it does not.

    An ideal gas at one temperature has p_in^2 - p_out^2 = 2 p drop for a drop at the
    density of p.
    """
    fluid, scene = plan.medium.fluid, plan.scene
    # a fluid of constant properties has no pressure
    if isinstance(scene.gas, GasConstant):
        return ""
    p, drop = scene.gas.pressure, abs(drop)
    change = drop * fluid.compressibility(plan.medium.T_fluid_in)
    if change < COMPRESSED:
        return ""
    at_outlet = (p**2 + 2.0 * p * drop) ** 0.5 - p
    left = p**2 - 2.0 * p * drop
    at_inlet = (
        f"a gas that enters at this pressure loses {p - left**0.5:.4g} Pa"
        if left > 0.0
        else "no gas that enters at this pressure passes the bed so fast"
    )
    return (
        f"{scene.origin.at(('gas', 'pressure'))}: gas.pressure: properties are those at "
        f"{p:.6g} Pa everywhere, and the pressure drop of {drop:.4g} Pa changes the "
        f"density by {100.0 * change:.3g} %: {at_inlet}, and one that leaves at it "
        f"loses {at_outlet:.4g} Pa; give the mean of the pressures at inlet and outlet, and "
        "the velocity at that pressure"
    )


def expanded(plan: Any, T: Array) -> str:
    """Return a warning where the density of a fluid that is stored changes so much over
    its temperatures (n,) [K] in a run that fronts move at another speed; empty where it
    does not.

    The mass flux is the same everywhere. With what a fluid displaces when it expands, the
    bed behind a front holds rho_in (h_in - h_0) for each volume of fluid that entered, not
    the integral of rho dh.
    """
    medium, scene = plan.medium, plan.scene
    span = float(T.min()), float(T.max())
    if scene.time is None or not plan.speed or span[0] == span[1]:
        return ""
    fluid, solid = medium.fluid, medium.solid
    porosity = scene.packed_bed.porosity
    between = np.linspace(*span, BETWEEN)
    density = np.broadcast_to(fluid.density(between), between.shape)
    hot = abs(medium.T_fluid_in - span[0]) > abs(medium.T_fluid_in - span[1])
    entering = density[-1 if hot else 0]
    capacity = fluid.heat_capacity(between)
    of_solid = solid.density(between) * solid.heat_capacity(between)
    held = np.mean(porosity * density * capacity + (1.0 - porosity) * of_solid)
    more = np.mean(porosity * (entering - density) * capacity)
    change = float(more / (held + more))
    if abs(change) < EXPANDED:
        return ""
    return (
        f"the density of {fluid.name} changes from {density[0]:.4g} to "
        f"{density[-1]:.4g} kg/m3 between {span[0]:.4g} and {span[1]:.4g} K, and the mass "
        "flux is taken to be the same everywhere: fronts of heat are "
        f"{abs(change) * 100.0:.2g} % {'slower' if change < 0.0 else 'faster'} than "
        "those of a fluid that expands"
    )


def lifted(plan: Any, T: Array) -> str:
    """Return a warning where the fluid lifts the bed at temperatures of the fluid
    (n,) [K]; empty where it does not.

    The bed axis of round beds points upwards, and a bed that moves descends. A bed at
    rest on another mesh has no direction, for which the warning is conditional. Left
    out are walls without slip, which carry a part of the bed, streams through curved
    inlets, and particles that are not denser than the fluid.
    """
    medium, axis = plan.medium, plan.mesh.axis
    velocity, solid = float(plan.velocity[axis]), float(plan.velocity_solid[axis])
    upright = plan.coordinate == "z"
    upwards = velocity > 0 if upright else velocity * solid <= 0
    if medium.solid is None or velocity == 0.0 or not upwards or plan.curved_inlet:
        return ""
    _, density, drag = resistance(plan, T)
    gradient = drag[axis]
    weight = (
        (1.0 - medium.scene.packed_bed.porosity)
        * (medium.solid.density(T) - density)
        * GRAVITY
    )
    k = int(np.argmax(np.abs(gradient) - weight))
    found, held = float(np.abs(gradient)[k]), float(np.broadcast_to(weight, T.shape)[k])
    # particles no denser than the fluid are held by something else
    if held <= 0.0 or found <= held:
        return ""
    known, key = upright or solid != 0.0, velocity_key(plan.scene.boundary, "fluid")
    return (
        f"{plan.scene.origin.at(parse_key(key))}: {key}: the pressure gradient at "
        f"{T[k]:.4g} K, "
        f"{found:.4g} Pa/m, exceeds the weight of the particles, {held:.4g} Pa/m: "
        f"{'the fluid' if known else 'if the fluid flows upwards, it'} fluidizes the "
        "bed; lower the velocity, take "
        "larger particles, or hold the bed down"
    )
