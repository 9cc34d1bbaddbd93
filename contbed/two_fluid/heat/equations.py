"""Heat of gas and particles, each with its own temperature, on the mass fluxes of the
flow.

    d(eps_g rho_g cp_g T_g)/dt + div(rho_g F_g cp_g T_g) = div(k_g grad T_g) + h a (T_s - T_g) + eps_g dp0/dt
    d(eps_s rho_s cp_s T_s)/dt + div(rho_s F_s cp_s T_s) = div(k_s grad T_s) + h a (T_g - T_s),   a = 6 eps_s/d_p

F [m/s] are the volume fluxes of the phases that the step moves, k_g and k_s [W/m/K]
effective conductivities of each phase per area of the bed, h [W/m2/K] the coefficient
of a particle. Radiation between particles is a part of k_s. Heat of friction and of
collisions is left out. An ideal gas at a low Mach number has rho_g = rho_ref
(T_ref/T_g) (p0/p_ref) with the thermodynamic pressure p0 [Pa] uniform: that outside of
the outlet or, in a closed bed, the one at which the mass of gas fills the volume; its
expansion is the divergence that the equation of pressure keeps,

    div(F_g + F_s) = 1/(rho_g cp_g T_g) (conducted and exchanged heat + eps_g dp0/dt) - eps_g/p0 dp0/dt

(Majda and Sethian 1985, Combust. Sci. Technol. 42, 185-205,
doi:10.1080/00102208508960376). What the last step left open between mass, temperature
and volume joins the divergence, so that it does not add up.

Walls of a given temperature heat a layer that cells need not resolve (wall_layer.py).
Convection is explicit and limited to second order, conduction implicit, first order in
time. Exchange weighs the new and the old difference of the temperatures by
w = 1/(1 - exp(-z)) - 1/z, z = dt (sum of the rates of both phases): exact for constant
h in a closed suspension at any dt, and with heat that moves or is given at a constant
rate (exponential fitting, Liniger and Willoughby 1970, SIAM J. Numer. Anal. 7, 47-66).
Mass and heat change by the fluxes of faces alone, so both close to rounding.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from contbed.errors import ConvergenceError
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.continuity import Moved
from contbed.two_fluid.fv.diffusion import conduct
from contbed.two_fluid.fv.gradient import FEW_PARTICLES, NO_PARTICLES
from contbed.two_fluid.fv.reconstruction import Reconstruction, divergence, face_values
from contbed.two_fluid.heat.implicit import (
    Exchange,
    add_exchange,
    divided_or_zero,
    implicit_changes,
    sums_over_faces,
)
from contbed.two_fluid.heat.model import HeatModel
from contbed.two_fluid.heat.wall_layer import Surroundings
from contbed.two_fluid.heat.walls import FromWalls, after_step, from_walls, memory
from contbed.two_fluid.linear.cg import EXPLICIT_SHARE
from contbed.two_fluid.model import Model
from contbed.two_fluid.operators import gradient, predictor_half_step
from contbed.two_fluid.state import Energy, State, booked, check_finite, fastest_gas
from contbed.two_fluid.timing import timed


class Conduction(NamedTuple):
    """What is conducted in a step.

    links (nf, 2) [J/K] : conductance of each face times dt; None if it is so small
        beside the content of the cells that explicit conduction is stable
    taken [J] : by own cells, from walls if all ranks are added up
    walls : None without walls of a given temperature
    """

    links: Array | None = None
    taken: float = 0.0
    walls: FromWalls | None = None


ROUNDING = 1e-9  # share of a sub-cycle by which a number of them may be off
# how often temperatures at adiabatic boundaries of skewed grids follow the gradient of
# their cell along these: heat along a strip of triangles is 6 % too large with 0 and
# 0.2 % with 2, which take 5 % of a step (test_steady_heat_is_linear)
ALONG_WALLS = 2
# share of its volume [-] that a step may leave open in a cell of ideal gas, as the
# pressure of a step knows the heat of the one before; it grows with the square of the
# step (test_moving_bed_keeps_heat_and_gas)
MAX_LEFT_OPEN = 1e-3


def density_times_T(p0: float, heat: HeatModel, model: Model) -> float:
    """Density times temperature [kg K/m3] of an ideal gas at p0 [Pa]."""
    return (
        model.materials.rho_gas * heat.physics.T_reference * p0 / heat.physics.pressure
    )


def closed_volume(heat: HeatModel, model: Model) -> bool:
    """Whether an ideal gas fills a volume without outlet."""
    return heat.ideal and model.pressure_solver.floating


def initial_energy(state: State, heat: HeatModel, model: Model) -> Energy:
    """Temperatures at their reference."""
    nc, T = len(state.eps_s), heat.physics.T_reference
    start = Energy(
        T_gas=np.full(nc, T),
        T_solid=np.full(nc, T),
        mass=np.empty(nc),
        rate_gas=np.zeros((nc, 1)),
        rate_solid=np.zeros((nc, 1)),
        rho_ratio=np.ones(nc),
        expansion=np.zeros(nc),
        closing=0.0,
        p0=heat.physics.pressure,
        walls=memory(heat, model),
    )
    return fill_with_gas(start, state.eps_s, heat, model)


def fill_with_gas(
    energy: Energy, eps_s: Array, heat: HeatModel, model: Model
) -> Energy:
    """Set mass [kg/m3] and density ratio of the gas by its equation of state at the
    given temperatures.
    """
    rho = (
        density_times_T(energy.p0, heat, model) / energy.T_gas
        if heat.ideal
        else model.materials.rho_gas
    )
    mass = (1.0 - eps_s) * rho
    return replace(
        energy, mass=mass, rho_ratio=_density_ratio(mass, eps_s, heat, model)
    )


def rate_of_steps(state: State, crossed: float, heat: HeatModel, model: Model) -> float:
    """Return one over the longest next step [1/s] that an ideal gas allows; 0 for a gas
    of constant density.

    What the last step left open between mass, temperature and volume limits its length,
    but the gas, which leaves a cell at the rate `crossed` [1/s], may always cross as
    much of a cell as the particles.
    """
    energy = state.energy
    assert energy is not None
    if not heat.ideal or state.dt == 0.0:
        return crossed / model.options.courant if heat.ideal else 0.0
    halo = model.grid.halo
    filled = energy.mass * energy.T_gas / density_times_T(energy.p0, heat, model)
    still_open = halo.max(
        float(np.max(np.abs(filled - (1.0 - state.eps_s))[halo.cells]))
    )
    return min(
        crossed / model.options.courant,
        float(np.sqrt(still_open / MAX_LEFT_OPEN)) / state.dt,
    )


def stored_heat(state: State, model: Model) -> float:
    """Heat in the bed [J] from 0 K; in a closed one filled with an ideal gas the
    internal energy.
    """
    energy, heat, volume = state.energy, model.heat, model.grid.geometry.volume
    assert energy is not None and heat is not None
    of_gas = heat.physics.cp_gas * energy.mass * energy.T_gas
    of_solid = (
        heat.physics.cp_solid * model.materials.rho_solid * state.eps_s * energy.T_solid
    )
    total = (of_gas + of_solid) @ volume
    return float(
        total
        - (
            energy.p0 * (1.0 - state.eps_s) @ volume
            if closed_volume(heat, model)
            else 0.0
        )
    )


@timed("energy")
def advance(
    state: State, energy: Energy, moved: Moved, heat: HeatModel, dt: float, model: Model
) -> tuple[Energy, Array]:
    """Advance the temperatures by `dt` [s], in which solids and gas have moved.

    Where the gas crosses more than the Courant number of a cell, in equal sub-cycles:
    the volume fluxes of the step stay, and the fractions change evenly, so that mass
    and heat close as in one. Return also the mean mass flux (nf,) of the gas over the
    usual density [m3/s].
    """
    halo = model.grid.halo
    crossed = dt * fastest_gas(state, halo) / model.options.courant
    count = max(1, int(np.ceil(crossed * (1.0 - ROUNDING))))
    filling = (moved.eps_s - state.eps_s) / count
    gas, gained, still_open = (
        np.zeros_like(moved.flux_gas),
        np.zeros_like(filling),
        filling,
    )
    for k in range(1, count + 1):
        eps_s = moved.eps_s if k == count else state.eps_s + k * filling
        part = moved._replace(eps_s=eps_s)
        energy, flux, still_open, more = _sub_cycle(
            state, energy, part, heat, dt / count, model
        )
        gas, gained = gas + flux / count, gained + more
    if heat.ideal:
        closing = max(dt, energy.closing - dt)
        expansion = (still_open * (dt / closing) + gained) / dt
        if closed_volume(heat, model):
            volume = model.grid.geometry.volume
            gained_volume, whole_volume = halo.sum(
                *_over_own_cells(model, expansion * volume, volume)
            )
            expansion = expansion - gained_volume / whole_volume
        energy = replace(energy, expansion=expansion, closing=closing)
    return energy, gas


def _sub_cycle(
    state: State, energy: Energy, moved: Moved, heat: HeatModel, dt: float, model: Model
) -> tuple[Energy, Array, Array, Array]:
    """Advance the temperatures by `dt` [s], a step or a sub-cycle of it.

    Return also the mass flux (nf,) of the gas over the usual density [m3/s], and shares
    of the volume (nc,) that gas fills: what is left open between mass, temperature and
    volume, and what heat adds.
    """
    p, g, s = heat.physics, model.grid.geometry, moved.eps_s
    rho_g, rho_s, volume = model.materials.rho_gas, model.materials.rho_solid, g.volume
    face_g, face_s = _face_temperatures(state, energy, moved, heat, dt, model)
    gas = (
        density_times_T(energy.p0, heat, model) / face_g * moved.flux_gas
        if heat.ideal
        else rho_g * moved.flux_gas
    )
    solid = rho_s * moved.flux
    net, moved_g, moved_s = (np.empty_like(s) for _ in range(3))
    divergence(g, solid, face_s, energy.T_solid, net, moved_s)
    divergence(g, gas, face_g, energy.T_gas, net, moved_g)
    mass = energy.mass - dt * net / volume

    content = np.stack(
        (p.cp_gas * mass * volume, p.cp_solid * rho_s * s * volume), axis=1
    )
    rates = np.stack((p.cp_gas * moved_g, p.cp_solid * moved_s), axis=1)
    given = _heat_walls(s, rates, heat, dt, model)
    carried = p.cp_gas * gas + p.cp_solid * solid
    conduction = _conduct(energy, s, content, rates, carried, heat, dt, model)
    links = conduction.links
    lift = divided_or_zero(dt * rates, content)
    at_gas, at_solid = add_exchange(state, energy, s, content, lift, heat, dt, model)
    exchange = Exchange(content, links, at_gas, at_solid)
    change, lost = implicit_changes(state, exchange, lift, model)
    p0 = energy.p0
    if closed_volume(heat, model):
        room = np.zeros_like(lift)
        room[:, 0] = (1.0 - s) * volume / content[:, 0]
        response, further = implicit_changes(state, exchange, room, model)
        rise = _pressure_rise(energy, mass, s, change, response, heat, model)
        p0 += rise
        change, lost = change + rise * response, lost + rise * further
    heat_flux = p.cp_gas * gas * face_g + p.cp_solid * solid * face_s
    new = replace(
        energy,
        T_gas=energy.T_gas + change[:, 0],
        T_solid=energy.T_solid + change[:, 1],
        mass=mass,
        rate_gas=(change[:, 0] / dt - moved_g / (mass * volume))[:, None],
        rate_solid=(
            change[:, 1] / dt - moved_s / (rho_s * (s + NO_PARTICLES) * volume)
        )[:, None],
        rho_ratio=_density_ratio(mass, s, heat, model),
        p0=p0,
        account=booked(
            energy.account,
            dt,
            (heat_flux, given + conduction.taken - lost, gas),
            model.grid,
        ),
    )
    if heat.has_walls:
        both = _of_both(content, np.stack((new.T_gas, new.T_solid), axis=1))
        falls = None if conduction.links is None else change
        new = after_step(new, conduction.walls, falls, both, heat, dt, model)
    model.grid.halo.exchange(
        new.T_gas, new.T_solid, new.mass, new.rate_gas, new.rate_solid, new.rho_ratio
    )
    _check_temperatures(state, new, model)
    if not heat.ideal:
        return new, moved.flux_gas, s, s
    return (
        new,
        gas / rho_g,
        *_filled(energy, new, change[:, 0], s, dt * moved_g / volume, model),
    )


def _density_ratio(mass: Array, eps_s: Array, heat: HeatModel, model: Model) -> Array:
    """Density of the gas over the usual one."""
    return (
        mass / (model.materials.rho_gas * (1.0 - eps_s))
        if heat.ideal
        else np.ones_like(eps_s)
    )


def _face_temperatures(
    state: State, energy: Energy, moved: Moved, heat: HeatModel, dt: float, model: Model
) -> tuple[Array, Array]:
    """Temperatures (nf,) that the fluxes of gas and solids carry through faces."""
    g, found = model.grid.geometry, []
    for T, entering, rate, u, flux, first_order, eps_s in (
        (
            energy.T_gas,
            heat.at_faces.T_gas,
            energy.rate_gas,
            state.u_gas,
            moved.flux_gas,
            model.no_cells,
            None,
        ),
        (
            energy.T_solid,
            heat.at_faces.T_solid,
            energy.rate_solid,
            state.u_solid,
            moved.flux,
            moved.upwind_cells,
            moved.eps_s,
        ),
    ):
        column, face = T[:, None], np.empty_like(flux)
        given, grad = _slope(T, entering, eps_s, model)
        half_step = predictor_half_step(model, dt, column, grad, u, rate)
        face_values(
            g,
            flux,
            Reconstruction(column, grad, half_step, given[:, None], first_order, True),
            face,
        )
        found.append(face)
    return found[0], found[1]


def _slope(
    T: Array, outside: Array, eps_s: Array | None, model: Model
) -> tuple[Array, Array]:
    """Temperature (nb,) at boundaries, `outside` or level across them, and gradient (nc,
    1, dim); of the solids with `eps_s`.
    """
    g, cells = model.grid.geometry, model.boundary_cells
    given = np.where(np.isnan(outside), T[cells], outside)
    grad = gradient(model, T[:, None], given[:, None], eps_s)
    if not g.skewed:
        return given, grad
    edges = slice(model.grid.interior, None)
    # from the foot of the centre to that of the face
    along = -g.distance[edges, None] * g.non_orthogonal[edges]
    for _ in range(ALONG_WALLS):
        there = T[cells] + (along * grad[cells, 0]).sum(axis=1)
        given = np.where(np.isnan(outside), there, outside)
        grad = gradient(model, T[:, None], given[:, None], eps_s)
    return given, grad


def _heat_walls(
    eps_s: Array, rates: Array, heat: HeatModel, dt: float, model: Model
) -> float:
    """Add the flux that is given at walls to `rates` (nc, 2) [W], shared by the
    fractions of the phases.

    Return the heat [J] that comes through own faces.
    """
    cells, area = model.boundary_cells, model.grid.geometry.area[model.grid.interior :]
    s = eps_s[cells]
    np.add.at(
        rates,
        cells,
        (heat.at_faces.flux * area)[:, None] * np.stack((1.0 - s, s), axis=1),
    )
    own = model.grid.halo.edges
    return dt * float(heat.at_faces.flux[own] @ area[own])


def _conduct(
    energy: Energy,
    eps_s: Array,
    content: Array,
    rates: Array,
    carried: Array,
    heat: HeatModel,
    dt: float,
    model: Model,
) -> Conduction:
    """Add what is conducted now to `rates` (nc, 2) [W]; gas and particles have moved
    the heat capacity `carried` (nf,) [W/K].
    """
    if heat.physics.conductivity is None and not heat.columns:
        return Conduction()
    g, halo = model.grid.geometry, model.grid.halo
    k_gas, k_solid, radiative = heat.physics.conductivities(
        eps_s, energy.T_gas, energy.T_solid
    )
    # the few particles of a nearly empty cell hold too little heat to conduct any
    some = np.minimum(1.0, eps_s / FEW_PARTICLES)
    contact = k_gas + some * k_solid
    k_solid = some * (k_solid + radiative)
    links, nowhere = (
        np.empty((len(g.left), 2)),
        np.full_like(heat.at_faces.wall, np.nan),
    )
    T, out = np.stack((energy.T_gas, energy.T_solid), axis=1), np.zeros_like(rates)
    grad = np.empty((0, 1, g.normal.shape[1]))
    for n, k in enumerate((k_gas, k_solid)):
        if g.skewed:
            fraction = eps_s if n else None
            grad = _slope(T[:, n], heat.at_faces.wall, fraction, model)[1]
        into, link = np.zeros((len(T), 1)), np.empty((len(g.left), 1))
        conduct(g, k, T[:, n], nowhere, grad, into, link)
        out[:, n], links[:, n] = into[:, 0], link[:, 0]
    walls = None
    if heat.columns:
        count = len(heat.layers.face)
        at = Surroundings(
            k_gas + k_solid,
            contact,
            content,
            T,
            links,
            out,
            carried,
            heat.at_faces.wall[heat.layers.face - model.grid.interior],
            np.zeros(count),
            np.zeros(count),
            0.5 * model.materials.d_p,
            False,
        )
        walls = from_walls(at, k_gas, eps_s, energy, heat, dt, model)
        np.add.at(out, heat.layers.cell, walls.rate)
        links[heat.layers.face] = walls.link
    rates += out
    links *= dt
    stiff = (sums_over_faces(links, model) > EXPLICIT_SHARE * content)[halo.cells].any()
    # what cells give each other cancels in the sum
    taken = dt * float(out[halo.cells].sum())
    return Conduction(links if halo.any(bool(stiff)) else None, taken, walls)


def _of_both(content: Array, T: Array) -> Array:
    """Return the temperature (nc,) [K] of gas and particles together."""
    both: Array = (content * T).sum(axis=1) / content.sum(axis=1)
    return both


def _pressure_rise(
    energy: Energy,
    mass: Array,
    eps_s: Array,
    change: Array,
    response: Array,
    heat: HeatModel,
    model: Model,
) -> float:
    """Rise of p0 [Pa] with which the gas fills a closed volume; temperatures rise by
    `response` (nc, 2) per Pa.
    """
    p, volume = heat.physics, model.grid.geometry.volume
    R = p.pressure / (model.materials.rho_gas * p.T_reference)
    gas, room = R * mass * volume, (1.0 - eps_s) * volume
    parts = _over_own_cells(
        model, gas * (energy.T_gas + change[:, 0]), room, gas * response[:, 0]
    )
    filled, pores, slope = model.grid.halo.sum(*parts)
    return (filled - energy.p0 * pores) / (pores - slope)


def _over_own_cells(model: Model, *fields: Array) -> list[float]:
    """Sum of each field (nc,) over own cells."""
    return [float(field[model.grid.halo.cells].sum()) for field in fields]


def _filled(
    old: Energy, new: Energy, change: Array, eps_s: Array, carried: Array, model: Model
) -> tuple[Array, Array]:
    """Return the shares of the volume (nc,) left open between mass, temperature and
    volume, and gained by heat.

    Over the time of a step they are the source of gas volume in its pressure equation.
    `change` (nc,) [K] is that of T_gas, `carried` the part of the change of mass times
    temperature that came with the gas.
    """
    heat, pores = model.heat, 1.0 - eps_s
    assert heat is not None
    before, now = (density_times_T(p0, heat, model) for p0 in (old.p0, new.p0))
    gained = new.mass * change
    still_open = (new.mass * old.T_gas + gained) / now - pores
    return still_open, (gained - carried) / now - (1.0 - before / now) * pores


def _check_temperatures(state: State, energy: Energy, model: Model) -> None:
    halo, message = model.grid.halo, ""
    own = ((energy.T_gas[halo.cells], "T_gas"), (energy.T_solid[halo.cells], "T_solid"))
    coldest, name = min((float(T.min()), name) for T, name in own)
    if not coldest > 0.0:
        message = (
            f"t = {state.time:.6g} s, step {state.steps}: {name} falls to "
            f"{coldest:.4g} K, not above 0 K: a wall with "
            "a negative heat_flux takes more heat than comes to it, or the steps are "
            "too long; give the wall a "
            "temperature in place of the flux, leave out time.step or lower "
            "time.courant"
        )
    if message := halo.first(message):
        check_finite(replace(state, energy=energy), model.grid)
        raise ConvergenceError(message)
