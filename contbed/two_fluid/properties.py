"""Closures at a state: drag, and what the particles' stress and granular temperature
need.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.boundary import boundary_velocity
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.model import Model
from contbed.two_fluid.operators import gradient
from contbed.two_fluid.state import Energy, Properties, State
from contbed.two_fluid.timing import timed

# solids fraction [-] below which pressure, viscosities and conductivity of the
# particles fade (test_random_fields_calm_down)
MIN_INTERACTING_FRACTION = 1e-8


def slip_speed(state: State) -> Array:
    """|u_gas - u_solid| (nc,) of each cell [m/s]."""
    slip = state.u_gas - state.u_solid
    speed: Array = np.sqrt(np.einsum("cd,cd->c", slip, slip))
    return speed


def density_ratio(energy: Energy | None) -> float | Array:
    """Density of the gas over the usual one."""
    return 1.0 if energy is None else energy.rho_ratio


@timed("closures")
def evaluate_closures(
    state: State, eps_s: Array, energy: Energy | None, model: Model
) -> Properties:
    """Closures at the new fraction and temperatures, and the other fields of the
    state.
    """
    speed = slip_speed(state)
    # the slip acts through a Reynolds number with the density of `materials`
    drag = model.closures.drag(eps_s, speed * density_ratio(energy))
    r = model.closures.granular(eps_s, state.theta, drag)
    # particles of a nearly empty cell have no pressure, stress or conduction
    share = eps_s / (eps_s + MIN_INTERACTING_FRACTION)
    faded = {
        name: getattr(r, name) * share
        for name in ("pressure", "mu", "bulk", "conductivity")
    }
    r = r._replace(**faded)
    rate = shear_rate(state.u_solid, eps_s, model) if model.closures.sheared else eps_s
    return Properties(drag, r, model.closures.friction(r.p_friction, rate))


def shear_rate(u_solid: Array, eps_s: Array, model: Model) -> Array:
    """Square root (nc,) of the second invariant of the particles' strain rate [1/s];
    partial-slip walls slip.
    """
    g, u, side = model.grid.geometry, u_solid, model.edge.solid
    given = np.empty_like(side.u)
    boundary_velocity(g, side, np.abs(side.slip), u, eps_s, given)
    grad = gradient(model, u, given, eps_s)
    ring = u[:, 0] / g.radius if model.grid.axisymmetric else np.zeros(len(u))
    strain = 0.5 * (grad + grad.transpose(0, 2, 1))
    trace = np.einsum("cii->c", strain) + ring
    square = np.einsum("cij,cij->c", strain, strain) + ring**2
    rate: Array = np.sqrt(0.5 * np.maximum(square - trace**2 / 3.0, 0.0))
    return rate
