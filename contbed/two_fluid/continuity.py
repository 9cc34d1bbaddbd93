"""Continuity of the solids: one limited volume flux that everything after it uses.

The flux of the last pressure equation is corrected by the implicit solids pressure, so
that a bed that packs resists within the step, and limited so that
0 <= eps_s <= eps_max. The flux of the gas is the rest of the total flux.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.compiled.threads import parallel
from contbed.two_fluid.compiled import Array, Flags
from contbed.two_fluid.fv import limiter
from contbed.two_fluid.implicit import solve_system
from contbed.two_fluid.linear.cg import empty_system
from contbed.two_fluid.model import Model
from contbed.two_fluid.solids_pressure import FrictionTable, Solids, move_tangents
from contbed.two_fluid.state import Counters, State
from contbed.two_fluid.timing import timed

# linearizations of the frictional pressure in a step, at most
# (test_slug_thrown_on_a_wall_packs_and_stays)
MAX_TANGENT_ROUNDS = 8


class Moved(NamedTuple):
    """The solids after a step.

    eps_s (nc,), rate_eps_s (nc, 1) [1/s] : new fraction; its rate of change, convection
        left out
    flux, flux_gas (nf,) [m3/s] : volume fluxes of solids and gas in the step
    compaction_velocity (nf,) [m/s] : velocity that the implicit solids pressure gives
        the particles
    upwind_cells (nc,) : cells that lost many of their particles; they give their own
        values to all faces
    """

    eps_s: Array
    rate_eps_s: Array
    flux: Array
    flux_gas: Array
    compaction_velocity: Array
    upwind_cells: Flags
    counters: Counters


@timed("continuity")
def advance(state: State, dt: float, model: Model) -> Moved:
    """Move the solids by `dt` [s]."""
    g, old, source = model.grid.geometry, state.eps_s, model.sources.solid
    table = FrictionTable(*model.closures.packing)
    solids = Solids(
        old,
        state.properties.drag,
        state.properties.rheology.stiffness,
        model.materials.rho_solid,
        model.open_faces
        * (state.properties.rheology.p_friction[model.boundary_cells] > 0.0),
    )
    system, flux, counters = (
        empty_system(g, 1),
        state.fluxes.solid.copy(),
        state.counters,
    )
    model.kernels.assemble_compaction(dt, solids, flux, source, system)
    # solved for in all cells: the small change ahead of a front keeps nearly empty
    # cells smooth
    y = solve_system(state, "eps_s", system, model, explicit=0.0)
    shift, halo = np.zeros(len(old)), model.grid.halo
    near = len(old) if halo.near is None else halo.near
    for _ in range(MAX_TANGENT_ROUNDS):
        if not halo.any(
            any(
                parallel(move_tangents, near, g.volume, table, solids, y, system, shift)
            )
        ):
            break
        counters = counters.add(packing_rounds=1)
        y = solve_system(
            state,
            "eps_s",
            system._replace(links=np.zeros_like(system.links)),
            model,
            explicit=0.0,
        )
    velocity = np.empty_like(flux)
    model.kernels.add_compaction_flux(dt, system, y, flux, velocity)
    new, upwind_cells = np.empty_like(old), np.zeros(len(old), dtype=np.bool_)
    bounds = limiter.Bounds(old, source, model.materials.eps_max)
    touched, rounds = limiter.limit(g, dt, bounds, flux, new, upwind_cells, halo)
    if touched:
        counters = counters.add(
            limited_faces=touched, limited_steps=1, limiter_rounds=rounds
        )
    rate = state.memory.rate_eps_s + (new - old).reshape(-1, 1) / dt
    return Moved(
        new, rate, flux, state.fluxes.total - flux, velocity, upwind_cells, counters
    )
