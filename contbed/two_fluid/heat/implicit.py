"""Implicit part of the heat of gas and particles: exchange weighed to be exact in time,
conduction by its own system.

The equations and their sources are those of `heat.equations`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contbed.errors import ConvergenceError
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.face_velocities import eliminate_drag
from contbed.two_fluid.fv.diffusion import conducted_out
from contbed.two_fluid.heat.model import HeatModel
from contbed.two_fluid.model import Model
from contbed.two_fluid.properties import slip_speed
from contbed.two_fluid.state import Energy, State

# of implicit conduction: residual over the right-hand side
TOLERANCE, MAX_ITERATIONS = 1e-10, 500
# dt times rate of exchange [-] below which the weight of the new difference is taken
# from its power series (test_conduction_in_one_phase)
MIN_EXCHANGE_NUMBER = 1e-3


class Exchange(NamedTuple):
    """Implicit part of heat.

    Content [J/K] of both phases (nc, 2), links (nf, 2) [J/K] of conduction in a step or
    None, and dt times the rates (nc,) [-] at which each phase follows the other,
    weighed.
    """

    content: Array
    links: Array | None
    at_gas: Array
    at_solid: Array


def add_exchange(
    state: State,
    energy: Energy,
    eps_s: Array,
    content: Array,
    lift: Array,
    heat: HeatModel,
    dt: float,
    model: Model,
) -> tuple[Array, Array]:
    """Add the exchange at the present temperatures to the `lift` (nc, 2) [K] of a step.

    Return dt times the rates at which each phase follows the other, weighed.
    """
    p, materials = heat.physics, model.materials
    h = p.coefficient(eps_s, slip_speed(state), energy.rho_ratio, energy.T_gas)
    of_solid = dt * 6.0 * h / (materials.d_p * materials.rho_solid * p.cp_solid)
    of_gas = of_solid * content[:, 1] / content[:, 0]
    apart = energy.T_solid - energy.T_gas
    lift[:, 0] += of_gas * apart
    lift[:, 1] -= of_solid * apart
    z = of_gas + of_solid
    weight = np.where(z < MIN_EXCHANGE_NUMBER, 0.5 + z / 12.0, 0.0)
    fast = z >= MIN_EXCHANGE_NUMBER
    weight[fast] = -1.0 / np.expm1(-z[fast]) - 1.0 / z[fast]
    return weight * of_gas, weight * of_solid


def implicit_changes(
    state: State, exchange: Exchange, lift: Array, model: Model
) -> tuple[Array, float]:
    """Return the changes of the temperatures (nc, 2) [K] with implicit conduction and
    exchange.

    `lift` is the explicit change. Return also the heat that the change drives out of
    own cells [J], through walls if all ranks are added up.
    """
    through = 0.0
    if exchange.links is not None:
        conducted = _solve_conduction(state, exchange, exchange.links, lift, model)
        # exchange follows exactly whatever the iteration has left
        lift = lift - divided_or_zero(conducted, exchange.content)
        through = float(conducted[model.grid.halo.cells].sum())
    return np.stack(
        eliminate_drag(lift[:, 0], lift[:, 1], exchange.at_gas, exchange.at_solid),
        axis=1,
    ), through


def _solve_conduction(
    state: State, exchange: Exchange, links: Array, lift: Array, model: Model
) -> Array:
    """Solve for implicit conduction with exchange; return the heat (nc, 2) [J] that the
    changes conduct out of cells.

    Conjugate gradients, preconditioned with the 2x2 block of each cell.
    """
    g, halo, content = model.grid.geometry, model.grid.halo, exchange.content
    own, both, out = (
        halo.cells,
        (content[:, 0] * exchange.at_gas)[:, None],
        np.empty_like(content),
    )
    diagonal = content + both + sums_over_faces(links, model)
    diagonal[diagonal == 0.0] = 1.0  # no particles
    scale = 1.0 / (diagonal[:, :1] * diagonal[:, 1:] - both**2)

    def product(x: Array) -> Array:
        halo.exchange(x)
        conducted_out(g, links, x, out)
        return content * x + out + both * (x - x[:, ::-1])

    def inverse(x: Array) -> Array:
        return scale * (diagonal[:, ::-1] * x + both * x[:, ::-1])

    def dots(*pairs: tuple[Array, Array]) -> Sequence[float]:
        return halo.sum(*(float(np.vdot(one[own], other[own])) for one, other in pairs))

    rhs = content * lift
    x = inverse(rhs)
    r = rhs - product(x)
    z = inverse(r)
    p = z.copy()
    whole, square, rho = dots((rhs, rhs), (r, r), (r, z))
    iterations = 0
    while not square <= TOLERANCE**2 * whole:
        if iterations == MAX_ITERATIONS:
            raise ConvergenceError(
                f"t = {state.time:.6g} s: heat did not converge in {MAX_ITERATIONS} "
                "iterations"
            )
        iterations += 1
        q = product(p)
        alpha = rho / dots((p, q))[0]
        x += alpha * p
        r -= alpha * q
        z, before = inverse(r), rho
        square, rho = dots((r, r), (r, z))
        p = z + rho / before * p
    halo.exchange(x)
    conducted_out(g, links, x, out)
    return out


def sums_over_faces(links: Array, model: Model) -> Array:
    """Return the sums (nc, 2) of `links` over the faces of each cell."""
    g = model.grid.geometry
    count = len(g.volume)
    both = [
        np.bincount(g.left, one, count)
        + np.bincount(g.right, one[: len(g.right)], count)
        for one in links.T
    ]
    return np.stack(both, axis=1)


def divided_or_zero(heat: Array, content: Array) -> Array:
    """heat/content, 0 where the content is 0."""
    return np.divide(heat, content, out=np.zeros_like(heat), where=content > 0.0)
