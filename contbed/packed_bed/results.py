"""From states to what a user reads: profiles along the bed and named results."""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.fem.probe import Probe, axis_points
from contbed.fields import header
from contbed.packed_bed.plan import Plan
from contbed.result import Result

APART = 0.01  # difference of theta at which the phases count as being in equilibrium


def _theta(T: Any, span: tuple[float, float]) -> Any:
    low, high = span
    return (T - low) / (high - low) if high > low else np.zeros_like(T)


def flow_findings(plan: Plan, flow: Any, result: Result) -> None:
    """Largest speed, pressure drop and pressure gradient, velocity along and across the bed."""
    space, _ = flow.system.fields["u"]
    axis, positions = plan.mesh.axis, None
    positions, points = axis_points(plan.mesh, plan.scene.output.positions)
    probe = Probe(plan.mesh, points)
    u = probe(space, flow.velocity[axis])
    pressure = probe(flow.system.fields["p"][0], flow.pressure)
    result.profiles = {header(plan.coordinate): positions, "u [m/s]": u, "p [Pa]": pressure}
    outlets = [name for name, kind in plan.conditions.items() if kind == "outlet"]
    facets = np.concatenate([plan.mesh.skfem.boundaries[name] for name in outlets])
    result.qoi |= {
        "u_max": float(np.sqrt((flow.velocity**2).sum(axis=0)).max()),
        "u_max_outlet": float(np.abs(flow.velocity[axis, space.on_facets(facets)]).max()),
        "pressure_drop_Pa": float(pressure[0] - pressure[-1]) * (1.0 if plan.velocity[axis] >= 0 else -1.0),
        "pressure_gradient_Pa_m": _developed_gradient(positions, pressure),
    }


def _developed_gradient(x: Any, p: Any) -> float:
    """Slope of the pressure at three quarters of the bed, away from inlet and outlet [Pa/m]."""
    length = x[-1] - x[0]
    low, high = np.searchsorted(x - x[0], [0.7 * length, 0.8 * length])
    return float((p[high] - p[low]) / (x[high] - x[low]))


def steady_findings(plan: Plan, problem: Any, state: Any, fluxes: Any, reactions: Any, result: Result) -> None:
    """Profiles, outlet temperatures, equilibrium and its length."""
    fluid, solid = _profiles(plan, problem, [state], None, result)
    span = problem.T_span
    result.nodal |= _nodal(problem, state)
    _outlets(plan, problem, state, result)
    heats = {name: value + sum(fluxes[name].values()) for name, value in reactions.items()}
    result.qoi |= {f"heat_{plan.as_written(name)}_W": value for name, value in heats.items()}
    if "tubes" in fluxes:
        result.qoi["heat_tubes_W"] = fluxes["tubes"]["radiation"]
    if span[1] > span[0] and float(plan.velocity @ plan.velocity_solid) >= 0:
        x = result.profiles[header(plan.coordinate)]
        gap = _theta(solid, span) - _theta(fluid, span)
        _equilibrium(x, gap, 0.5 * (_theta(solid, span) + _theta(fluid, span)), result)


def _equilibrium(x: Any, gap: Any, mean: Any, result: Result) -> None:
    """Where the phases come within `APART` and stay, by log-linear interpolation of the gap, and theta at the end."""
    inside = np.abs(gap) <= APART
    if not inside[-1] or inside[0]:
        return
    k = int(np.flatnonzero(~inside)[-1])
    a, b = abs(gap[k]), max(abs(gap[k + 1]), 1e-300)
    result.qoi["theta_equilibrium"] = float(mean[-1])
    result.qoi["equilibrium_length_m"] = float(x[k] + (x[k + 1] - x[k]) * np.log(a / APART) / np.log(a / b))


def _outlets(plan: Plan, problem: Any, state: Any, result: Result) -> None:
    """Mean outlet temperature of each stream, weighted with its mass flux."""
    for phase in ("fluid", "solid"):
        carried = flow = 0.0
        for _, part, wall in problem.walls:
            if wall.name != f"T_{phase}" or wall.mass_flux is None:
                continue
            out = problem.system.integrate(lambda u, o, c=wall: o.dot(c.mass_flux, o.n), [part], state)
            if out > 0:
                flow += out
                carried += problem.system.integrate(
                    lambda u, o, c=wall: o.dot(c.mass_flux, o.n) * getattr(u, c.name), [part], state
                )
        if flow > 0:
            result.qoi[f"T_{phase}_out_K"] = carried / flow


def _nodal(problem: Any, state: Any) -> dict[str, Any]:
    space = problem.system.fields["T_fluid"][0]
    return {name: (space, problem.system.part(state, name)) for name in problem.system.fields}


def _profiles(plan: Plan, problem: Any, states: list[Any], times: list[float] | None, result: Result) -> Any:
    positions, points = axis_points(plan.mesh, plan.scene.output.positions)
    probe = Probe(plan.mesh, points)
    space = problem.system.fields["T_fluid"][0]
    fluid = np.array([probe(space, problem.system.part(state, "T_fluid")) for state in states])
    solid = np.array([probe(space, problem.system.part(state, "T_solid")) for state in states])
    _columns(plan, positions, fluid, solid, problem.T_span, times, result)
    if problem.radiation is not None:
        G = [problem.system.part(state, "G") for state in states]
        slope = [probe.slope(space, values, plan.mesh.axis) for values in G]
        result.profiles |= {
            "G [W/m2]": np.array([probe(space, values) for values in G]).ravel(),
            "q_radiation [W/m2]": -problem.radiation.optics.diffusion * np.array(slope).ravel(),
        }
    return (fluid, solid) if times is not None else (fluid[0], solid[0])


def _columns(
    plan: Plan, positions: Any, fluid: Any, solid: Any, span: tuple[float, float], times: Any, result: Result
) -> None:
    """Profile columns; the rows of a transient run through the positions for each time."""
    columns = {header(plan.coordinate): np.tile(positions, len(fluid))}
    if times is not None:
        columns["t [s]"] = np.repeat(np.asarray(times, dtype=float), len(positions))
    columns |= {"T_fluid [K]": fluid.ravel(), "T_solid [K]": solid.ravel()}
    if span[1] > span[0]:
        columns |= {
            "theta_fluid [1]": _theta(fluid, span).ravel(),
            "theta_solid [1]": _theta(solid, span).ravel(),
        }
    result.profiles = columns | {k: v for k, v in result.profiles.items() if times is None and k not in columns}


def transient_findings(plan: Plan, problem: Any, history: Any, result: Result) -> None:
    """Profiles at the output times, fields of each, number of steps."""
    result.qoi |= {"time_steps": history.steps, "time_reached_s": history.time}
    times, snapshots = [*history.times], [*history.snapshots]
    if history.steps and (not times or times[-1] < history.time * (1 - 1e-12)):  # a run that was stopped
        times.append(history.time)
        snapshots.append(history.state)
    if not snapshots:
        return
    _profiles(plan, problem, snapshots, times, result)
    flow = dict(result.nodal)
    result.series = [(time, flow | _nodal(problem, state)) for time, state in zip(times, snapshots, strict=True)]
    result.nodal |= _nodal(problem, snapshots[-1])
    _outlets(plan, problem, snapshots[-1], result)


def front_findings(plan: Plan, snapshots: list[Any], backwards: bool, result: Result) -> None:
    """Profiles of a bed with tracked fronts; `backwards` when the stream enters at the right end."""
    time = plan.scene.time
    assert time is not None
    length = plan.scene.mesh.length  # type: ignore[union-attr]
    positions = np.unique(plan.scene.output.positions)
    if not len(positions):
        positions = np.linspace(0.0, length, 1001)
    along = length - positions if backwards else positions
    fluid, solid = (np.array(part) for part in zip(*(snapshot.at(along) for snapshot in snapshots), strict=True))
    T = (plan.medium.T_fluid_in, time.initial_fluid, time.initial_solid)
    _columns(plan, positions, fluid, solid, (min(T), max(T)), [snapshot.time for snapshot in snapshots], result)
    result.qoi |= {"T_fluid_out_K": float(fluid[-1, 0 if backwards else -1])}
