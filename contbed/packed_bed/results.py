"""Results of a packed bed from its states: profiles along the bed and named results."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.fem.ad.dual import plain
from contbed.fem.probe import Line
from contbed.fields import header
from contbed.packed_bed import of_heaters
from contbed.packed_bed.heat import INSIDE
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.pressure import (
    along_bed,
    along_way,
    direction,
    expanded,
    is_tilted,
    lifted,
    resistance,
)
from contbed.packed_bed.streams import Streams, outlet_table, streams
from contbed.result import Result
from contbed.scene.boundary import FLUXES, conditions_of
from contbed.scene.mesh import power_units

if TYPE_CHECKING:
    from contbed.packed_bed.schumann import Schumann

TEMPERATURES = ("T_fluid", "T_solid")
PASSED = ("inlet", "outlet")
POINTS = 1001  # places and times at which a closed form is written
APART = 0.01  # difference of theta at which the phases count as being in equilibrium


def _theta(T: Any, span: tuple[float, float]) -> Any:
    low, high = span
    return (T - low) / (high - low) if high > low else np.zeros_like(T)


def flow_findings(plan: Plan, line: Line, flow: Any, result: Result) -> None:
    """Fill in largest speed, pressure drop, pressure gradient, and velocity and
    pressure along the bed.
    """
    from contbed.packed_bed.flow import is_across

    space, _ = flow.system.fields["u"]
    axis = plan.mesh.axis
    velocity = flow.expanded
    of_pressure = flow.system.fields["p"][0]
    result.profiles = {
        header(plan.coordinate): line.positions,
        header("u"): line.probe(space, velocity[axis]),
        header("p"): line.probe(of_pressure, flow.pressure),
    }
    pressure = line.whole.probe(of_pressure, flow.pressure)
    speed = np.sqrt((velocity**2).sum(axis=0))
    axis_of_bed = np.eye(len(velocity))[axis]
    ends = [name for name, kind in plan.roles.items() if kind in PASSED]
    straight = all(is_across(plan.mesh, name, axis_of_bed) for name in ends)
    leaving = np.abs(velocity[axis]) if straight else speed
    outlet = leaving[space.on_facets(_facets(plan, "outlet"))]
    result.qoi |= {
        "u_max": float(speed.max()),
        "u_max_outlet": float(outlet.max(initial=0.0)),
    }
    entering, out = (_mean_pressure(plan, flow, kind) for kind in PASSED)
    if entering is not None and out is not None:
        result.qoi["pressure_drop_Pa"] = entering - out
    elif straight:  # through a closed vessel
        along = 1.0 if plan.velocity[axis] >= 0 else -1.0
        result.qoi["pressure_drop_Pa"] = along * float(pressure[0] - pressure[-1])
    if straight:
        gradient = _developed_gradient(line.whole.positions, pressure)
        result.qoi["pressure_gradient_Pa_m"] = gradient


def _mean_pressure(plan: Plan, flow: Any, kind: str) -> float | None:
    """Return the mean pressure over all boundaries of a kind of flow [Pa]; None where
    there are none.
    """
    names = [name for name, role in plan.roles.items() if role == kind]
    if not names:
        return None
    parts = [part for name in names for part in flow.system.boundary(name)]
    force = flow.system.integrate(lambda u, o: u.p, parts, flow.state)
    area = flow.system.integrate(lambda u, o: 1.0 + 0.0 * u.p, parts, flow.state)
    return float(force / (flow.porosity * area))


def _facets(plan: Plan, kind: str) -> Any:
    """Return the facets of all boundaries of a kind of flow."""
    found = [
        plan.mesh.skfem.boundaries[name]
        for name, role in plan.roles.items()
        if role == kind
    ]
    return np.concatenate([np.zeros(0, dtype=int), *found])


def _integral(y: Any, x: Any) -> float:
    """Return the integral of y over x by the trapezoidal rule; to import scipy's
    takes longer than a small run.
    """
    return float(0.5 * (y[1:] + y[:-1]) @ np.diff(x))


def _developed_gradient(x: Any, p: Any) -> float:
    """Return the slope of the pressure at three quarters of the bed, away from inlet
    and outlet [Pa/m].
    """
    length = x[-1] - x[0]
    low, high = np.searchsorted(x - x[0], [0.7 * length, 0.8 * length])
    return float((p[high] - p[low]) / (x[high] - x[low]))


def steady_findings(
    plan: Plan,
    line: Line,
    problem: Any,
    state: Any,
    fluxes: Any,
    conducted: Any,
    result: Result,
) -> None:
    """Fill in profiles, outlet temperatures, equilibrium and the length to reach it."""
    _profiles([plan], line, problem, [state], None, result)
    fluid, solid = (_along_whole(line, problem, state, name) for name in TEMPERATURES)
    x, span = line.whole.positions, problem.T_span
    result.nodal |= _nodal(problem, state)
    leaving, entering = streams(problem, state)
    _outlets(leaving, result)
    result.qoi |= _means(problem, state)
    _exchanger(plan, problem, entering, fluxes, (x, solid - fluid), result)
    result.qoi |= _heats(plan, fluxes, conducted)
    for inside, otherwise in (
        ("tubes", "immersed_tubes"),
        ("species", "radiating_species"),
    ):
        if inside in fluxes.get(INSIDE, {}):
            # a boundary may be called so as well
            result.qoi[f"heat_{inside if inside not in conducted else otherwise}_W"] = (
                fluxes[INSIDE][inside]
            )
    result.units |= power_units(result.qoi, plan.scene.mesh)
    if span[1] > span[0] and float(plan.velocity @ plan.velocity_solid) >= 0:
        gap = _theta(solid, span) - _theta(fluid, span)
        _equilibrium(x, gap, 0.5 * (_theta(solid, span) + _theta(fluid, span)), result)


def _heats(plan: Plan, fluxes: Any, conducted: Any) -> dict[str, float]:
    """Return the heat through each boundary by its result."""
    return {
        f"heat_{plan.as_written(name)}_W": value + sum(fluxes[name].values())
        for name, value in conducted.items()
    }


def wall_findings(
    plan: Plan, fluxes: Any, conducted: Any, time: float, result: Result
) -> None:
    """Report the mean heat through each wall over a run of some time [s], from the
    heat through all boundaries [J]; none of those that streams pass at some time.
    """
    from contbed.packed_bed.flow import is_across

    parts = [0.5 * (each.start + each.end) for each in plan.intervals() if each]
    ends = {
        name
        for part in (plan, *plan.at(parts))
        for name in plan.mesh.boundaries
        if part.roles.get(name) in PASSED
        or is_across(plan.mesh, name, part.velocity_solid)
    }
    walls = {name: value for name, value in conducted.items() if name not in ends}
    heated = {
        f"heat_{name}_W" for name, table in plan.scene.boundary.items() if table.heated
    }
    heats = _heats(plan, fluxes, walls)
    result.qoi |= {
        name: heat / time for name, heat in heats.items() if heat or name in heated
    }
    result.units |= power_units(result.qoi, plan.scene.mesh)


def _equilibrium(x: Any, gap: Any, mean: Any, result: Result) -> None:
    """Return where the phases come within `APART` and stay, and theta at the end.

    The position is found by log-linear interpolation of the gap.
    """
    inside = np.abs(gap) <= APART
    if not inside[-1] or inside[0]:
        return
    k = int(np.flatnonzero(~inside)[-1])
    a, b = abs(gap[k]), max(abs(gap[k + 1]), 1e-300)
    result.qoi["theta_equilibrium"] = float(mean[-1])
    result.qoi["equilibrium_length_m"] = float(
        x[k] + (x[k + 1] - x[k]) * np.log(a / APART) / np.log(a / b)
    )


def _outlets(leaving: Streams, result: Result) -> None:
    """Report the mean outlet temperature of each stream."""
    result.qoi |= {f"T_{phase}_out_K": T for phase, (_, T) in leaving.items()}


def _means(problem: Any, state: Any) -> dict[str, float]:
    """Return the mean temperatures of both phases by volume."""
    cells = problem.system.cells
    return {
        f"{name}_mean_K": problem.system.integrate(
            lambda unknowns, o, name=name: getattr(unknowns, name), [cells], state
        )
        / float(np.sum(cells.weight))
        for name in TEMPERATURES
    }


def _exchanger(
    plan: Plan,
    problem: Any,
    entering: Streams,
    fluxes: Any,
    gap: tuple[Any, Any],
    result: Result,
) -> None:
    """Report the heat that the fluid takes up, its share of the most that streams of
    these inlets could exchange, and the pinch.

    `gap` are positions and the difference of temperatures there.
    """
    if "fluid" not in entering:
        return
    duty = -sum(flux["T_fluid"] for flux in fluxes.values() if "T_fluid" in flux)
    result.qoi |= {"duty_W": duty, "heat_reference_K": problem.T_span[0]}
    # a prescribed temperature at an inlet conducts heat in beside what the stream
    # carries
    conditions = [each for *_, each in conditions_of(plan.solved.boundary)]
    fixed = any(each.fixed_temperature for each in conditions)
    if len(entering) < 2:
        return
    low, high = problem.T_span
    result.qoi |= of_heaters.pinch(*gap, high - low)
    heated = any(getattr(each, key) for each in conditions for key in FLUXES)
    # the streams exchange heat with more than each other
    if fixed or heated:
        return
    temperatures = [T for _, T in entering.values()]
    contents = [
        flow
        * abs(
            float(np.ptp(getattr(plan.medium, phase).enthalpy(np.array(temperatures))))
        )
        for phase, (flow, _) in entering.items()
    ]
    opposite = of_heaters.opposite(plan.velocity, plan.velocity_solid)
    result.qoi |= of_heaters.effectiveness(duty, contents, opposite)


def _nodal(problem: Any, state: Any) -> dict[str, Any]:
    space = problem.system.fields["T_fluid"][0]
    hidden = {mode.name for mode in problem.modes}
    own = {
        name: (space, problem.system.part(state, name))
        for name in problem.system.fields
        if name not in hidden
    }
    return own | {
        name: (space, values) for name, values in _inside(problem, state).items()
    }


def _inside(problem: Any, state: Any) -> dict[str, Any]:
    """Return the temperatures of surface and centre of the particles at all nodes;
    none without temperatures inside.
    """
    if not problem.modes:
        return {}
    mean, part = problem.system.part(state, "T_solid"), problem.system.part
    return {
        "T_surface": mean + sum(part(state, mode.name) for mode in problem.modes),
        "T_centre": mean
        + sum(mode.centre * part(state, mode.name) for mode in problem.modes),
    }


def _stream(
    plans: list[Plan],
    line: Line,
    problem: Any,
    states: list[Any],
    fluid: Any,
    result: Result,
) -> None:
    """Report velocity, density and pressure of the fluid along the bed; the last state
    gives the pressure drop.

    `plans` hold the velocity of each state, `fluid` are its temperatures on the line,
    one row for each state.
    """
    plan = plans[-1]
    axis, medium = plan.mesh.axis, plan.medium
    velocities = [float(each.velocity[axis]) for each in plans]
    space = problem.system.fields["T_fluid"][0]
    _tell_if_lifted(plans, fluid, result)
    if text := expanded(plan, np.ravel(fluid)):
        result.warnings.append(text)
    if plan.plug and any(velocities):
        whole = line.whole
        if whole is not line:
            fluid = [
                whole.probe(space, problem.system.part(state, "T_fluid"))
                for state in states
            ]
        tilted = is_tilted(plan)
        if not tilted:
            u = _along(plans, line, whole.positions, fluid, result)
        if velocities[-1]:
            on_line = plan.mesh.skfem.dim() == 1
            mean = (
                _integral(1.0 / np.abs(u), whole.positions)
                if on_line
                else _mean_stay(medium, problem, states[-1])
            )
            result.qoi["residence_time_s"] = medium.scene.packed_bed.porosity * mean
            if tilted or not (on_line or _crosses(plan)):
                drop = _drop_by_sections(plan, problem, states[-1])
                result.qoi["pressure_drop_Pa"] = drop
    elif problem.flow is not None:
        density = np.broadcast_to(medium.fluid.density(fluid[-1]), fluid[-1].shape)
        if header("u") in result.profiles:
            result.profiles[header("rho_fluid")] = density


def _along_whole(line: Line, problem: Any, state: Any, name: str) -> Any:
    """Return the values of a field from end to end of the bed."""
    space = problem.system.fields[name][0]
    return line.whole.probe(space, problem.system.part(state, name))


def _along(plans: list[Plan], line: Line, x: Any, fluid: Any, result: Result) -> Any:
    """Report velocity, density and pressure along the bed by the temperatures of the
    fluid at x [m], one row for each plan; return the velocities of the last [m/s].
    """
    streams = [along_bed(plan, x, T) for plan, T in zip(plans, fluid, strict=True)]
    for name, column in (("u", "u"), ("rho_fluid", "density"), ("p", "pressure")):
        values = [getattr(stream, column) for stream in streams]
        if x is not line.positions:
            values = [np.interp(line.positions, x, value) for value in values]
        result.profiles[header(name)] = np.concatenate(values)
    plan, last = plans[-1], streams[-1]
    if along := plan.velocity[plan.mesh.axis]:
        # where particles drag the fluid along it is below zero
        result.qoi["pressure_drop_Pa"] = float(last.pressure[0 if along > 0 else -1])
    return last.u


def _drop_by_sections(plan: Plan, problem: Any, state: Any) -> float:
    """Return the pressure drop [Pa] by means over the sections of a bed, whose
    temperatures differ across the flow or which is tilted, see `pressure`.
    """
    medium, way, cells = plan.medium, direction(plan), problem.system.cells

    def against(unknowns: Any, o: Any) -> Any:
        T = plain(unknowns.T_fluid)
        return -(way @ resistance(plan, T.ravel())[2]).reshape(T.shape)

    held = problem.system.integrate(against, [cells], state)
    friction = held * along_way(plan) / float(np.sum(cells.weight))
    friction *= np.sign(way @ plan.velocity)
    flux = medium.mass_flux_scale() * float(np.linalg.norm(plan.velocity))
    momentum = [
        (flux / medium.scene.packed_bed.porosity) ** 2 / float(medium.fluid.density(T))
        for side in streams(problem, state)
        for _, T in [side["fluid"]]
    ]
    return float(friction + momentum[0] - momentum[1])


def plug_findings(plan: Plan, line: Line, result: Result) -> None:
    """Fill in what plug flow gives without temperatures: velocity, density and
    pressure along the bed, pressure drop and residence time.
    """
    x = line.whole.positions
    T = np.full(len(x), plan.medium.T_fluid_in)
    _tell_if_lifted([plan], [T], result)
    result.profiles = {header(plan.coordinate): line.positions}
    porosity = plan.scene.packed_bed.porosity
    if is_tilted(plan):
        u, _, drag = resistance(plan, T[:1])
        way, length = direction(plan), along_way(plan)
        result.qoi["pressure_drop_Pa"] = -float(way @ drag[:, 0]) * length
        stay = length / float(np.linalg.norm(u))
    else:
        speed = np.abs(_along([plan], line, x, [T], result))
        stay = _integral(1.0 / speed, x)
    result.qoi["residence_time_s"] = porosity * stay
    result.closures = [use.to_dict() for use in plan.medium.ranges()]


def _crosses(plan: Plan) -> bool:
    """Whether the fluid crosses the bed at an angle, so that streams enter through
    several sides.
    """
    return int(np.count_nonzero(plan.velocity)) > 1


def _mean_stay(medium: Any, problem: Any, state: Any) -> float:
    """Return the mass that would fill the bed without particles over the mass flow
    of all streams that enter [s].
    """
    held = problem.system.integrate(
        lambda unknowns, o: medium.fluid.density(unknowns.T_fluid),
        [problem.system.cells],
        state,
    )
    return float(held / streams(problem, state)[1]["fluid"][0])


def _tell_if_lifted(plans: list[Plan], T: Any, result: Result) -> None:
    """Warn of a fluid that fluidizes the bed at its temperatures [K], one row for
    each plan; once for each velocity.
    """
    rows: dict[tuple[bytes, float], tuple[Plan, list[Any]]] = {}
    for plan, row in zip(plans, T, strict=True):
        flow = plan.velocity.tobytes() + plan.velocity_solid.tobytes()
        rows.setdefault((flow, plan.medium.T_fluid_in), (plan, []))[1].append(row)
    told: dict[bytes, str] = {}
    for (flow, _), (plan, found) in rows.items():
        text = lifted(plan, np.ravel(found))
        if text:
            told.setdefault(flow, text)
    result.warnings += told.values()


def _profiles(
    plans: list[Plan],
    line: Line,
    problem: Any,
    states: list[Any],
    times: list[float] | None,
    result: Result,
) -> None:
    plan, positions, probe = plans[-1], line.positions, line.probe
    space = problem.system.fields["T_fluid"][0]
    fluid = np.array(
        [probe(space, problem.system.part(state, "T_fluid")) for state in states]
    )
    solid = np.array(
        [probe(space, problem.system.part(state, "T_solid")) for state in states]
    )
    _columns(plan, positions, fluid, solid, problem.T_span, times, result)
    _stream(plans, line, problem, states, fluid, result)
    if problem.modes:
        inner = [_inside(problem, state) for state in states]
        result.profiles |= {
            header(name): np.array(
                [probe(space, found[name]) for found in inner]
            ).ravel()
            for name in inner[0]
        }
    if problem.radiation is not None:
        G = [problem.system.part(state, "G") for state in states]
        slope = [probe.slope(space, values, plan.mesh.axis) for values in G]
        result.profiles |= {
            "G [W/m2]": np.array([probe(space, values) for values in G]).ravel(),
            "q_radiation [W/m2]": -problem.radiation.optics.diffusion
            * np.array(slope).ravel(),
        }


def _columns(
    plan: Plan,
    positions: Any,
    fluid: Any,
    solid: Any,
    span: tuple[float, float],
    times: Any,
    result: Result,
) -> None:
    """Return the profile columns; the rows of a transient run through the positions
    for each time.
    """
    columns = {header(plan.coordinate): np.tile(positions, len(fluid))}
    if times is not None:
        columns["t [s]"] = np.repeat(np.asarray(times, dtype=float), len(positions))
    columns |= {"T_fluid [K]": fluid.ravel(), "T_solid [K]": solid.ravel()}
    if span[1] > span[0]:
        columns |= {
            "theta_fluid [1]": _theta(fluid, span).ravel(),
            "theta_solid [1]": _theta(solid, span).ravel(),
        }
    result.profiles = columns | {
        k: v for k, v in result.profiles.items() if times is None and k not in columns
    }


def transient_findings(
    plan: Plan, line: Line, problem: Any, history: Any, result: Result
) -> None:
    """Fill in profiles at the output times, fields of each, the outlet over time,
    and the number of steps.
    """
    result.qoi |= {"time_steps": history.steps, "time_reached_s": history.time}
    if history.outlet:
        result.tables["outlet"] = outlet_table(history.outlet)
    times, snapshots = [*history.kept], [*history.kept.values()]
    # a run that was stopped
    if history.steps and (not times or times[-1] < history.time * (1 - 1e-12)):
        times.append(history.time)
        snapshots.append(history.state)
    if not snapshots:
        return
    _profiles(plan.at(times), line, problem, snapshots, times, result)
    flow = dict(result.nodal)
    # `flow` is that at the end
    changes = problem.flow is not None and problem.flow.local is not None
    result.series = [
        (time, ({} if changes and time < times[-1] else flow) | _nodal(problem, state))
        for time, state in zip(times, snapshots, strict=True)
    ]
    result.nodal |= _nodal(problem, snapshots[-1])
    _outlets(streams(problem, snapshots[-1])[0], result)
    result.qoi |= _means(problem, snapshots[-1])


def front_findings(
    plan: Plan,
    bed: Schumann,
    times: list[float],
    heat: dict[str, float],
    result: Result,
) -> None:
    """Fill in profiles of a bed by its closed form, which begins where the stream
    enters, its outlet over time, and what it stores of the `heat` of streams [J].
    """
    from contbed.packed_bed.of_stores import closed_store_findings

    length = plan.scene.mesh.length  # type: ignore[union-attr]
    positions = np.unique(plan.scene.output.positions)
    if not len(positions):
        positions = np.linspace(0.0, length, POINTS)
    backwards = plan.velocity[0] < 0

    def at(x: Any, time: float) -> tuple[Any, Any]:
        return bed.at(length - x if backwards else x, time)

    fluid, solid = (
        np.array(part)
        for part in zip(*(at(positions, time) for time in times), strict=True)
    )
    _tell_if_lifted([plan], fluid[-1:], result)
    T = (bed.inlet, bed.fluid, bed.solid)
    _columns(
        plan,
        positions,
        fluid,
        solid,
        (min(T), max(T)),
        times,
        result,
    )
    every = np.union1d(np.linspace(0.0, times[-1], POINTS)[1:], times)
    leaving = bed.at(length, every)[0]
    result.tables["outlet"] = {"t [s]": every, "T_fluid_out [K]": leaving}
    result.qoi |= {"T_fluid_out_K": float(leaving[-1])}
    x = np.linspace(0.0, length, POINTS)
    pressure = along_bed(plan, x, at(x, times[-1])[0]).pressure
    result.qoi["pressure_drop_Pa"] = float(pressure[-1 if backwards else 0])
    closed_store_findings(plan, bed, np.array([every, leaving]), heat, result)
