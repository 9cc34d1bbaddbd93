"""Results of columns of adsorbent, or of solids at rest that take up a gas by reaction:
when gases break through, and what a cycle separates.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from contbed.arrays import Array
from contbed.course.history import SAME
from contbed.reacting_bed.course import Course
from contbed.reacting_bed.history import FLOW, BedHistory
from contbed.reacting_bed.problem import Problem

MIDDLE = 50
FEW_CELLS = 3.5  # of a mass-transfer zone, up to which it may be that of the cells
LEVELS = (1, 5, MIDDLE, 95)  # percent of the mole fraction that enters
MOMENTS = ((0.0, 0.5, 1.0), (1 / 6, 4 / 6, 1 / 6))  # and weights of Simpson's rule


def column_findings(course: Course, history: BedHistory) -> dict[str, float]:
    """Return results of a column: of a run from clean to loaded, or of a cycle."""
    solids = course.scene.solids.values()
    adsorbed = {gas for each in solids for gas in each.adsorption or {}}
    taken = adsorbed | _taken_by_reactions(course.problem)
    if not taken or not history.outlet:
        return {}
    rows = dict(zip(history.columns, np.array(history.outlet).T, strict=True))
    if course.time.cycle is not None:
        return separated(course, rows) if adsorbed else {}
    found: dict[str, float] = {}
    streams = course.at(0.0, before=False).streams
    until = course.cuts[1] * (1 + SAME) if course.schedule else np.inf
    first = rows["t [s]"] <= until
    for name in sorted(taken):
        if entering := streams.gas.get(name, 0.0):
            x = rows[f"x_{name} [1]"]
            shares = (
                x * streams.moles / entering,
                x * rows[FLOW] / entering,
            )
            curve = np.array([rows["t [s]"], *shares])[:, first]
            length = course.scene.mesh.length
            found |= breakthrough(name, curve, length)
    return found


def _taken_by_reactions(problem: Problem) -> set[str]:
    """Return the gases that react with what solids at rest hold."""
    if problem.bed.velocity_solid:
        return set()
    gases, solids = problem.species.gases, problem.species.solids
    found: set[str] = set()
    for reaction in problem.reactions:
        used = {name for name, n in reaction.stoichiometry.items() if n < 0.0}
        if not used.isdisjoint(solids):
            found |= used & set(gases)
    return found


def early_fronts(course: Course, found: Mapping[str, float]) -> list[str]:
    """Warn of fronts that leave early by more than solver.accuracy, as the gas in the
    voids is left out.
    """
    scene = course.scene
    if (
        course.problem.bed.gas_pressure is not None
        or scene.packed_bed.gas_storage != "auto"
    ):
        return []
    times = {
        name: time
        for name, time in found.items()
        if name.startswith(f"breakthrough_{MIDDLE}_")
    }
    delay = course.at(0.0, before=False).gas_residence
    early = [name for name, t in times.items() if delay > scene.solver.accuracy * t]
    if not early:
        return []
    share = max(delay / times[name] for name in early)
    return [
        f"{scene.origin.place(('packed_bed', 'gas_storage'))}: the gas in the voids is "
        f"left out: fronts leave {delay:.3g} s early, {share:.2g} of "
        f'{early[0]}; give packed_bed.gas_storage = "stored"'
    ]


def narrow_zones(
    course: Course, history: BedHistory, found: Mapping[str, float]
) -> list[str]:
    """Warn of mass-transfer zones that may be those of the cells, where these have one
    value or are damped.
    """
    line = course.on(history).problem.line
    cell = float(line.h.max())
    if line.degree and not history.damped.any():
        return []
    return [
        f"{name} = {length:.3g} m is {length / cell:.2g} cells: where "
        "nothing else spreads the front it shrinks with the cells, and breakthrough at "
        "1 and 5 % comes later: give closures.dispersion_mass for the spread that beds "
        "have, or more mesh.cells"
        for name, length in found.items()
        if name.startswith("mass_transfer_zone_") and length < FEW_CELLS * cell
    ]


def breakthrough(name: str, curve: Array, length: float) -> dict[str, float]:
    """Return when a gas breaks through, the mass-transfer zone and the share of the
    capacity that is used.

    Parameters
    ----------
    curve : time [s], and what leaves over what enters, as mole fraction and as flow,
        (3, steps)
    length : of the column [m]
    """
    t, x, flow = np.insert(curve, 0, (0.0, 0.0, 0.0), axis=1)
    when = {level: _reached(t, x, 0.01 * level) for level in LEVELS}
    found = {
        f"breakthrough_{level}_{name}_s": time
        for level, time in when.items()
        if time is not None
    }
    early, half, late = when[5], when[50], when[95]
    if early is None or half is None or late is None:
        return found
    found[f"mass_transfer_zone_{name}_m"] = length * (late - early) / half
    kept = np.concatenate([[0.0], np.cumsum(np.diff(t) * (1.0 - _middles(flow)))])
    used, whole = np.interp([early, late], t, kept)
    return found | {f"capacity_used_{name}": float(used / whole)}


def _middles(y: Array) -> Array:
    middles: Array = 0.5 * (y[1:] + y[:-1])
    return middles


def _reached(t: Array, x: Array, level: float) -> float | None:
    """Return the first time [s] at which x reaches a level; None if it does not, or
    in the first step already.
    """
    above = np.flatnonzero(x >= level)
    if not len(above) or above[0] < 2:
        return None
    k = int(above[0])
    share = (level - x[k - 1]) / (x[k] - x[k - 1])
    return float(t[k - 1] + share * (t[k] - t[k - 1]))


def separated(course: Course, rows: Mapping[str, Array]) -> dict[str, float]:
    """Return purity, recovery and productivity of each gas of a cycle, in the part
    between changes of the streams in which it leaves purest.
    """
    parts, gases = list(pairwise(course.cuts)), course.problem.layout.gases
    left = [_left(rows, gases, start, end) for start, end in parts]
    entered = [_entered(course, gases, start, end) for start, end in parts]
    fed = np.sum(entered, axis=0)
    streams, period = course.problem.streams, course.time.end
    mass = sum(streams.densities.values()) * course.scene.mesh.length
    found: dict[str, float] = {}
    for k, name in enumerate(gases):
        shares = [moles[k] / moles.sum() for moles in left if moles.sum() > 0.0]
        amounts = [moles[k] for moles in left if moles.sum() > 0.0]
        if len(shares) < 2 or not fed[k] > 0.0:
            continue
        best = int(np.argmax(shares))
        found[f"purity_{name}"] = float(shares[best])
        found[f"recovery_{name}"] = float(amounts[best] / fed[k])
        if mass:
            found[f"productivity_{name}_mol_kgs"] = float(
                amounts[best] / (mass * period)
            )
    return found


def _left(
    rows: Mapping[str, Array], gases: tuple[str, ...], start: float, end: float
) -> Array:
    """Return the moles of each gas that leave between two times, per area [mol/m2]."""
    t = rows["t [s]"]
    inside = (t > start * (1 + SAME)) & (t <= end * (1 + SAME))
    steps = np.diff(np.concatenate([[start], t[inside]]))
    flow = np.abs(rows[FLOW])[inside]
    out = []
    for name in gases:
        rate = rows[f"x_{name} [1]"][inside] * flow
        # a jump of the streams is one of what leaves
        rate = np.concatenate([rate[:1], rate])
        out.append(_middles(rate) @ steps)
    return np.array(out)


def _entered(course: Course, gases: tuple[str, ...], start: float, end: float) -> Array:
    """Return the moles of each gas that enter between two times, per area [mol/m2]."""
    total = np.zeros(len(gases))
    for share, weight in zip(*MOMENTS, strict=True):
        time = start + share * (end - start)
        streams = course.at(time, before=share > 0.0).streams
        rates = [abs(streams.gas[name]) for name in gases]
        total += weight * (end - start) * np.array(rates)
    return total
