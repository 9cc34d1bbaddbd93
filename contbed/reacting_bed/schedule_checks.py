"""Checks of what changes in the course of a run: series, and other checks at each of
their times.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.scene.checking import Mistakes, See
from contbed.scene.mesh import MeshLine
from contbed.scene.series import series_of
from contbed.scene.series_checks import (
    a_cycle_fits_its_series,
    output_times_lie_in_the_run,
    series_is_usable,
)
from contbed.scene.toml_lines import Origin

Boundaries = dict[str, s.Boundary]
# of the gas, the last also of solid phases
FLOWS = ("mass_flux", "molar_flux", "velocity")
LEAST_FLOW = 1e-7  # of the largest, below which fluxes of species give no composition


def series_are_usable(
    boundary: Boundaries, time: s.Time | None, see: See, origin: Origin
) -> Mistakes:
    """Check that series can be read, begin at 0 and last as long as the run, and
    that the gas never stops.
    """
    for path, series in series_of(boundary, ("boundary",)):
        found = list(series_is_usable(path, series, time, see, origin))
        yield from found
        if path[-1] in FLOWS and not found:
            yield from _flow_keeps_its_sign(path, series.samples(origin.base))


def _flow_keeps_its_sign(path: Any, samples: Any) -> Mistakes:
    values = [float(value) for value in samples.values]
    slowest = min(values, key=abs)
    if path[2] == "gas" and abs(slowest) <= LEAST_FLOW * max(map(abs, values)):
        moment = samples.times[values.index(slowest)]
        flows = (
            f"no gas flows at {moment:g} s"
            if slowest == 0.0
            else f"next to no gas flows at {moment:g} s"
        )
        yield (
            path,
            f"{flows}; composition is that of the fluxes of species, which a gas at "
            "rest does not have: give a small "
            "flow, such as 1 % of the usual one",
        )
    if samples.form == "linear":
        for k, (a, b) in enumerate(pairwise(values)):
            if a * b < 0.0:
                moments = f"{samples.times[k]:g} and {samples.times[k + 1]:g} s"
                yield (
                    path,
                    f"passes through 0 between {moments}; a flow turns in a jump: form "
                    '= "step"',
                )


def a_cycle_changes_something(
    boundary: Boundaries, time: s.Time | None, see: See
) -> Mistakes:
    """Check that a cycle has series, of which it is an integer number of periods."""
    what = "a composition, a flow, or a temperature of what enters or of the wall"
    yield from a_cycle_fits_its_series(boundary, time, what, see)


def initial_profiles_fit_the_bed(
    mesh: MeshLine, initial: s.Initial, see: See, origin: Origin
) -> Mistakes:
    """Check that the file of the state at the start can be read and lies within the
    bed; the plan reads its columns.
    """
    if initial.file is None:
        return
    from contbed.reacting_bed.initial_rows import KEY, rows_of
    from contbed.scene.profile import outside_of_the_bed

    try:
        rows = rows_of(initial, origin.base)
    except SceneError as error:
        yield KEY, str(error)
        return
    assert rows is not None
    yield from outside_of_the_bed(KEY, rows, mesh.length, see)


def initial_profiles_reach_both_ends(
    mesh: MeshLine, initial: s.Initial, see: See, origin: Origin
) -> Mistakes:
    """Look for a file of the state at the start that leaves much of the bed at its
    first or last row.
    """
    if initial.file is None:
        return
    from contbed.reacting_bed.initial_rows import KEY, rows_of
    from contbed.scene.profile import short_of_an_end

    rows = rows_of(initial, origin.base)
    assert rows is not None
    yield from short_of_an_end(KEY, rows, mesh.length, "state", see)


def cells_can_follow(
    mesh: MeshLine, solver: s.Solver, time: s.Time | None, see: See
) -> Mistakes:
    """Check that cells which follow errors are not refined by hand, and in time that
    nothing holds them.
    """
    if mesh.refine and mesh.cells is None:
        yield (
            ("mesh", "refine"),
            "has no effect on cells that the run chooses; give mesh.cells, which it "
            "divides",
        )
    if time is None or not solver.adapt:
        return
    if mesh.cells is not None:
        yield (
            ("solver", "adapt"),
            f"cells do not follow errors beside {see('mesh.cells')}; remove one of both",
        )
    elif time.cycle is not None:
        yield (
            ("solver", "adapt"),
            f"cells do not follow errors in {see('time.cycle')}; give mesh.cells "
            "instead",
        )


def times_are_in_order(
    time: s.Time | None,
    continuation: s.Continuation | None,
    solids: dict[str, s.Solid],
    packed_bed: s.PackedBed,
    initial: s.Initial,
    see: See,
) -> Mistakes:
    """Check that output times lie within the run, and that a branch is one of steady
    states.
    """
    if time is None:
        return
    yield from output_times_lie_in_the_run(time, see)
    follows = packed_bed.gas_storage == "quasi_steady" and not any(
        table.adsorption for table in solids.values()
    )
    if follows and initial.gas.composition is not None:
        text = (
            "has no meaning for a gas that follows at once; see "
            f"{see('packed_bed.gas_storage')}"
        )
        yield ("initial", "gas", "composition"), text
    if continuation is not None:
        yield (
            ("continuation",),
            f"follows steady states, and the scene is transient; see {see('time')}",
        )
