"""Results of stores of heat: a bed at rest that a stream charges or discharges in time.

A run is cut into the parts between changes of its streams. In each of them the stream
leaves heat in the bed, or takes it out, and what passes the walls is lost. Exergy
counts from the dead state: per mass of the stream it is

    e(T) = h(T) - h(T0) - T0 (s(T) - s(T0)),   s(T) - s(T0) = integral of dh/T

at one pressure. Source: Dincer, Rosen, Thermal Energy Storage, 3rd ed., Wiley (2021),
chapter 7.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.fem.probe import Line
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.schedule import ScheduleInterval, initial_temperatures
from contbed.packed_bed.schumann import Schumann
from contbed.result import Result
from contbed.scene.mesh import power_units

Intervals = list[tuple[ScheduleInterval | None, Plan]]
POINTS = 8  # of the quadrature of entropy
EDGES = (0.1, 0.9)  # scaled temperatures between which the thermocline lies
SAME = 1e-12
# streams that take more than they brought, beyond the error of a cycle, take what walls
# or the start of the run gave, which is no efficiency
MOST_EFFICIENT = 1.01
ROUNDING = 1e-9  # of a share of all that streams could give


@dataclass(frozen=True)
class Part:
    """A part of a run in which the flow is constant.

    left : heat that the stream leaves in the bed [J]; lost : heat that leaves it
        otherwise [J]
    most : heat that the stream could leave between the inlet temperatures [J]
    exergy : what the stream leaves in the bed [J]; flows : whether there is a stream
    """

    left: float
    lost: float
    most: float
    exergy: float
    flows: bool


def store_findings(
    plan: Plan,
    line: Line,
    problem: Any,
    history: Any,
    totals: tuple[float, float],
    result: Result,
) -> None:
    """Add results of a store.

    Parameters
    ----------
    line : along the bed
    problem : of the last part of the run
    totals : heat by streams of the fluid and otherwise, into the bed over the run [J]
    """
    intervals = _intervals(plan)
    temperatures = _temperatures(plan, intervals)
    if temperatures is None:
        return
    low, high = min(temperatures), max(temperatures)
    parts = list(_parts(intervals, problem, history, totals, (low, high)))
    medium, volume = plan.medium, float(np.sum(problem.system.cells.weight))
    capacity = volume * sum(
        float(content(high) - content(low))
        for content in (medium.content_fluid, medium.content_solid)
    )
    result.qoi |= exchanged(parts) | used(parts, history.gain, capacity)
    whole, of_solid = line.whole, problem.system.fields["T_solid"][0]
    T = whole.probe(of_solid, problem.system.part(history.state, "T_solid"))
    _add_thermocline(plan, whole.positions, T, (low, high), result)


def closed_store_findings(
    plan: Plan, bed: Schumann, outlet: Array, heat: dict[str, float], result: Result
) -> None:
    """Add results of a store by its closed form.

    Parameters
    ----------
    outlet : times [s] and temperatures of the fluid that leaves [K] (2, n)
    heat : that entered and left with the stream and is stored [J]
    """
    times, leaving = np.insert(outlet, 0, (0.0, outlet[1, 0]), axis=1)
    low, high = sorted((bed.inlet, bed.solid))
    if high - low <= 0.0:
        return
    fluid, dead = plan.medium.fluid, plan.scene.packed_bed.dead_state
    flow = float(
        np.linalg.norm(plan.velocity) * plan.section * fluid.density(bed.inlet)
    )
    e_in, e_out = (
        exergy(fluid.enthalpy, T, dead)
        for T in (np.full(len(times), bed.inlet), leaving)
    )
    ends = fluid.enthalpy(np.array([low, high]))
    part = Part(
        heat["in"] - heat["out"],
        0.0,
        flow * float(ends[1] - ends[0]) * float(times[-1]),
        flow * _over_time(e_in - e_out, times),
        True,
    )
    volume = bed.length * plan.section
    capacity = (bed.capacity_fluid + bed.capacity_solid) * volume * (high - low)
    result.qoi |= exchanged([part]) | used([part], heat["stored"], capacity)
    z = np.linspace(0.0, bed.length, len(times))
    _add_thermocline(plan, z, bed.at(z, times[-1])[1], (low, high), result)


def _add_thermocline(
    plan: Plan, x: Array, T: Array, span: tuple[float, float], result: Result
) -> None:
    """Add the thermocline to the results of a store, and the units of all of them."""
    thickness = thermocline(x, T, span)
    if thickness is not None:
        result.qoi["thermocline_m"] = thickness
    result.units |= power_units(result.qoi, plan.scene.mesh)


def exchanged(parts: Sequence[Part]) -> dict[str, float]:
    """Return the heat that streams leave in the bed and take out of it, and its share
    of what they could.
    """
    charging = [part for part in parts if part.left > 0.0]
    discharging = [part for part in parts if part.left < 0.0]
    charged = sum((part.left for part in charging), 0.0)
    taken = sum((-part.left for part in discharging), 0.0)
    out = {"heat_charged_J": charged, "heat_discharged_J": taken}
    could = sum(part.most for part in charging), sum(part.most for part in discharging)
    if 0.0 < taken <= charged * MOST_EFFICIENT:
        out["storage_efficiency"] = taken / charged
    shares = (("charge", charged, could[0]), ("discharge", taken, could[1]))
    for way, passed, most in shares:
        # more than all is heat of walls beyond the temperatures of the streams
        if most > 0.0 and passed <= most * (1.0 + ROUNDING):
            out[f"effectiveness_{way}"] = passed / most
    stored = sum((part.exergy for part in parts if part.exergy > 0.0), 0.0)
    given = sum((-part.exergy for part in parts if part.exergy < 0.0), 0.0)
    out |= {"exergy_charged_J": stored, "exergy_discharged_J": given}
    if 0.0 < given <= stored * MOST_EFFICIENT:
        out["exergy_efficiency"] = given / stored
    return out


def used(parts: Sequence[Part], gain: float, capacity: float) -> dict[str, float]:
    """Return what the bed loses and holds, and the share of its capacity in use;
    `gain` is what it holds more at the end [J].
    """
    out = {"heat_lost_J": sum(part.lost for part in parts), "heat_stored_J": gain}
    resting = [part.lost for part in parts if not part.flows]
    if resting:
        out["heat_lost_at_rest_J"] = sum(resting)
    held = np.cumsum([0.0, *(part.left - part.lost for part in parts)])
    # streams as warm as the bed at its start
    if capacity > 0.0:
        out["storage_capacity_J"] = capacity
        out["utilisation"] = float(np.ptp(held)) / capacity
    return out


def exergy(enthalpy: Callable[[Any], Any], T: Any, dead: float) -> Any:
    """Return the exergy of a stream [J/kg] at temperatures T [K], from its enthalpy
    [J/kg] and the dead state [K].
    """
    T = np.asarray(T, dtype=float)
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    between = dead + (T[..., None] - dead) * 0.5 * (nodes + 1.0)
    zero = enthalpy(np.array(dead))
    rise = enthalpy(T) - zero
    inner = ((enthalpy(between) - zero) / between**2) @ weights * 0.5 * (T - dead)
    return rise - dead * (rise / T + inner)


def thermocline(x: Array, T: Array, span: tuple[float, float]) -> float | None:
    """Return the distance between the places where T passes `EDGES` of the span; None
    where it does not pass each once.
    """
    low, high = span
    places = []
    for edge in EDGES:
        above = T - (low + edge * (high - low))
        crossed = np.flatnonzero(above[1:] * above[:-1] <= 0.0)
        crossed = crossed[above[crossed] != above[crossed + 1]]
        if len(crossed) != 1:
            return None
        k = int(crossed[0])
        share = above[k] / (above[k] - above[k + 1])
        places.append(x[k] + share * (x[k + 1] - x[k]))
    return float(abs(places[1] - places[0]))


def _intervals(plan: Plan) -> Intervals:
    """Return the parts of a run with the plan of the flow in each."""
    return [
        (interval, plan if interval is None else plan.within(interval))
        for interval in plan.intervals()
    ]


def _temperatures(plan: Plan, intervals: Intervals) -> list[float] | None:
    """Return the temperatures at which the fluid enters, of a run that is no cycle also
    those of the bed at the start [K]; None where the bed is no store.
    """
    for _, there in intervals:
        if np.any(there.velocity_solid) or np.count_nonzero(there.velocity) > 1:
            return None
    found = [
        T
        for interval, there in intervals
        for time in ((0.0,) if interval is None else (interval.start, interval.end))
        if (T := _inlet(there, interval, time)) is not None
    ]
    scene = plan.scene
    if not found or scene.time is None:
        return None
    if scene.time.cycle is None:
        found += initial_temperatures(scene, ["solid"])
    return found


def _parts(
    intervals: Intervals,
    problem: Any,
    history: Any,
    totals: tuple[float, float],
    span: tuple[float, float],
) -> Iterator[Part]:
    """Yield the parts of a run up to the time that it has reached."""
    rows = np.array([(0.0,) * 5, *history.outlet])
    if intervals[0][0] is None:  # not summed step by step
        rows[:, 3:] = np.outer(rows[:, 0] / rows[-1, 0], totals)
    starts = [0.0 if interval is None else interval.start for interval, _ in intervals]
    ends = [*starts[1:], rows[-1, 0]]
    for (interval, there), start, end in zip(intervals, starts, ends, strict=True):
        first = np.searchsorted(rows[:, 0], start * (1 - SAME))
        after = np.searchsorted(rows[:, 0], end * (1 + SAME), side="right")
        own = rows[first:after]
        if len(own) < 2:
            continue
        left, other = own[-1, 3:] - own[0, 3:]
        volume, times = _volume_flow(there, problem), own[:, 0]
        if volume == 0.0:
            yield Part(float(left), -float(other), 0.0, 0.0, False)
            continue
        inlets = _inlets_at(there, interval, times)
        fluid = there.medium.fluid
        flow = volume * np.broadcast_to(fluid.density(inlets), len(times))
        low, high = fluid.enthalpy(np.array(span))
        yield Part(
            float(left),
            -float(other),
            _over_time(flow, times) * float(high - low),
            _over_time(flow * _exergy_left(there, inlets, own), times),
            True,
        )


def _inlets_at(plan: Plan, interval: ScheduleInterval | None, times: Array) -> Array:
    """Return the temperature at which the fluid enters at each of these times [K]."""
    changes = interval is not None and bool(interval.schedule)
    found = [_inlet(plan, interval, time) for time in (times if changes else times[:1])]
    given = [plan.medium.T_fluid_in if T is None else T for T in found]
    return np.broadcast_to(given, len(times))


def _exergy_left(plan: Plan, inlets: Array, rows: Array) -> Array:
    """Return the exergy that the stream of a part leaves in the bed at the time of each
    row [J/kg].
    """
    out = rows[:, 1].copy()
    out[0] = out[1]  # before the part another stream leaves
    dead = plan.scene.packed_bed.dead_state
    enthalpy = plan.medium.fluid.enthalpy
    left: Array = exergy(enthalpy, inlets, dead) - exergy(enthalpy, out, dead)
    return left


def _over_time(values: Array, times: Array) -> float:
    """Return an integral over time by the trapezoidal rule with slopes."""
    slope, steps = np.gradient(values, times), np.diff(times)
    return float(
        0.5 * (values[1:] + values[:-1]) @ steps - np.diff(slope) @ steps**2 / 12.0
    )


def _inlet(plan: Plan, interval: ScheduleInterval | None, time: float) -> float | None:
    """Return the temperature at which the fluid enters at a time [K]; None where none
    does.
    """
    for name in _inlets(plan):
        if interval is None:
            condition = plan.solved.boundary[name].thermal("fluid")
        else:
            weights = interval.interpolation_weights(time)
            condition = interval.boundary(weights)[name].thermal("fluid")
        if condition is not None:
            for T in (condition.temperature, condition.fixed_temperature):
                if T is not None:
                    return float(T)  # type: ignore[arg-type]  # frozen: a number
    return None


def _inlets(plan: Plan) -> list[str]:
    return [name for name, kind in plan.roles.items() if kind == "inlet"]


def _volume_flow(plan: Plan, problem: Any) -> float:
    """Return the volume flow of the fluid at the inlet [m3/s]."""
    speed = float(np.linalg.norm(plan.velocity))
    area = sum(
        float(np.sum(part.weight))
        for name in _inlets(plan)
        for part in problem.system.boundary(name)
    )
    return speed * area
