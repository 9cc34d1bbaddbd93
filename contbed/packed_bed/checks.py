"""Checks of a packed bed: mistakes that remain although every single value is valid;
see `scene.checking`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.closures.packed_beds import unusable
from contbed.errors import SceneError
from contbed.packed_bed import scene as s
from contbed.packed_bed.closures import bound, places
from contbed.packed_bed.corners import prescribed_temperatures_agree_in_corners
from contbed.packed_bed.heat_checks import (
    heat_alone_uses_temperatures,
    heat_has_its_properties,
    particles_that_melt_are_lumped,
    radiation_counts_once,
    the_gas_conducts_once,
    the_inside_of_particles_fits_the_scene,
)
from contbed.packed_bed.inlets import (
    bed_axis,
)
from contbed.packed_bed.schedule_checks import (
    NAMES,
    Boundaries,
    initial_profiles_fit_the_bed,
    initial_profiles_reach_both_ends,
)
from contbed.packed_bed.stream_checks import (
    flow_has_a_way_through,
    streams_have_a_temperature,
)
from contbed.packed_bed.temperature_checks import (
    polynomials_stay_positive,
    temperatures_lie_in_the_table,
)
from contbed.packed_bed.velocity_checks import (
    velocities_are_given_once,
    velocities_are_meant_as_steps,
    velocities_fit_the_mesh,
)
from contbed.packed_bed.wall_checks import (
    a_steady_temperature_is_determined,
    phases_conduct_what_they_get,
    temperatures_are_those_of_walls,
    the_side_of_a_line_passes_heat,
)
from contbed.radiation.checks import (
    optics_attenuate,
    radiation_is_complete,
    solids_fit_together,
    solids_sum_to_one,
    tubes_see_radiation,
    two_flux_scatters_evenly,
)
from contbed.radiation.scene import Radiation
from contbed.radiation.thickness import (
    rosseland_is_thick,
    rosseland_rests,
    two_flux_is_low,
)
from contbed.scene.boundary import conditions_of
from contbed.scene.checking import Check, Mistakes, See
from contbed.scene.gas import Gas, GasCantera, GasCoolProp
from contbed.scene.mesh import Mesh, MeshFile, MeshLine
from contbed.scene.mesh_checks import (
    mesh_file_exists,
    names_exist,
    places_across,
    positions_along,
)
from contbed.scene.quantities import ClosureFile
from contbed.scene.series_checks import (
    a_cycle_fits_its_series,
    output_times_lie_in_the_run,
    series_are_usable,
)
from contbed.scene.tables import FieldOutput
from contbed.scene.toml_lines import KeyPath, Origin

# tolerance of a balance above which a warning is given: the accuracy that engineers ask
# for
LOOSE_BALANCE = 1e-3


def tables_are_complete(
    heat: s.Heat | None,
    radiation: Radiation | None,
    gas: Gas | None,
    packed_bed: s.PackedBed | None,
    solids: Mapping[str, s.Solid],
) -> Mistakes:
    """Check that the tables that belong together are present."""
    alone = heat is None and radiation is not None
    if alone:
        if gas is not None:
            yield (
                ("gas",),
                "has no meaning with [radiation] alone; add [heat] or remove it",
            )
        return
    needed_by = "[heat]" if heat is not None else "the flow"
    for name, table in (("gas", gas), ("packed_bed", packed_bed), ("solids", solids)):
        if not table:
            yield (name,), f"this table is missing; {needed_by} needs it"


def one_solid_fills_the_bed(
    solids: Mapping[str, s.Solid],
    radiation: Radiation | None,
    boundary: Boundaries,
    initial: s.Initial,
) -> Mistakes:
    """Check that one solid fills the bed, that others radiate, and that conditions
    are of the one.
    """
    if not solids:
        return
    filling = s.that_fill_the_bed(solids)
    if len(filling) != 1:
        found = ", ".join(filling) or "none"
        yield (
            ("solids",),
            f"a bed without species has one solid with a density; found {found}; "
            "others only radiate. For a mixture of sizes give each a volume_share, and "
            'gas.model = "cantera" or "ideal_gas"',
        )
        return
    name, solid = next(iter(filling.items()))
    if solid.temperature is not None and radiation is None:
        yield (
            ("solids", name, "temperature"),
            "has no meaning without a [radiation] table",
        )
    for other, table in solids.items():
        if other != name and radiation is None:
            yield (
                ("solids", other),
                f"has no meaning without a [radiation] table: '{name}' fills the bed",
            )
        elif other != name and table.inside is not None:
            yield (
                ("solids", other, "inside"),
                f"has no meaning: '{name}' fills the bed, this solid only radiates",
            )
    named: list[KeyPath] = [
        path for path, phase, _ in conditions_of(boundary) if phase != "gas"
    ]
    named += [("initial", "solids", other) for other in initial.solids]
    for path in named:
        if path[-1] != name:
            yield path, f"the solid that fills the bed is '{name}'"


def a_run_in_time_has_a_start(time: s.Time | None, initial: s.Initial) -> Mistakes:
    """Check that a transient run has temperatures at the start."""
    if time is None:
        return
    for phase, name in NAMES.items():
        if initial.given(phase) is None:
            key = "gas" if phase == "fluid" else "solids.NAME"
            yield (
                ("initial",),
                f"the {name} has no temperature at the start; give "
                f"initial.{key}.temperature",
            )


def profiles_lie_in_the_bed(
    mesh: Mesh, output: FieldOutput, boundary: Boundaries, see: See
) -> Mistakes:
    """Check that the line of profiles lies within a built-in mesh."""
    axis = bed_axis(mesh, boundary)
    yield from positions_along(mesh, output, see, axis)
    yield from places_across(mesh, output, see, axis)


def the_packing_fits_the_bed(
    mesh: Mesh, solids: Mapping[str, s.Solid], see: See
) -> Mistakes:
    """Check that the particles are smaller than a built-in bed."""
    if isinstance(mesh, MeshFile):
        return
    for name, solid in s.that_fill_the_bed(solids).items():
        if solid.diameter > mesh.length:
            yield (
                ("solids", name, "diameter"),
                f"{solid.diameter:g} m is more than the length of the bed, "
                f"{see('mesh.length')}; is a unit missing?",
            )


def gases_make_sense(gas: Gas) -> Mistakes:
    """Check the temperature range and the composition of the gas."""
    if isinstance(gas, GasCoolProp) and gas.T_range[0] >= gas.T_range[1]:
        yield ("gas", "T_range"), "the lower temperature comes first"
    if isinstance(gas, GasCantera):
        from contbed.materials.composition import require_sum

        try:
            require_sum(gas.composition)
        except SceneError as error:
            yield ("gas", "composition"), str(error)


def times_are_in_order(time: s.Time | None, see: See) -> Mistakes:
    """Check that output times and steps lie within the run."""
    if time is None:
        return
    for index, instant in enumerate(time.times):
        if instant in time.times[:index]:
            yield ("time", "times", index), f"{instant:g} s is given twice"
    yield from output_times_lie_in_the_run(time, see)
    if time.step is not None and time.step > time.end:
        yield (
            ("time", "step"),
            f"{time.step:g} s is more than the whole run; see {see('time.end')}",
        )
    if time.step is not None and "tolerance" in time.model_fields_set:
        yield (
            ("time", "tolerance"),
            f"has no meaning with a fixed step; remove one; see {see('time.step')}",
        )


def a_cycle_changes_something(
    time: s.Time | None, boundary: Boundaries, mesh: Mesh, see: See
) -> Mistakes:
    """Check that a cycle has series, without which nothing changes in the course of
    a period.
    """
    if time is None or time.cycle is None:
        return
    what = "a velocity or a temperature"
    yield from a_cycle_fits_its_series(boundary, time, what, see)
    if not isinstance(mesh, MeshLine):
        yield (
            ("time", "cycle"),
            'the cyclic steady state is found on a line; use mesh.type = "line"',
        )


def closures_exist(
    mesh: Mesh,
    closures: s.Closures,
    heat: s.Heat | None,
    boundary: Boundaries,
    origin: Origin,
) -> Mistakes:
    """Check that the closures exist and that the bed has the arguments that they
    need.
    """

    def bind(path: KeyPath, spec: Any, kind: str) -> None:
        found = bound(spec, kind, origin.base)
        narrow = isinstance(mesh, MeshLine) and mesh.diameter is None
        if narrow and "D_bed" in found.takes and not isinstance(spec, ClosureFile):
            name = spec if isinstance(spec, str) else spec.name
            raise SceneError(
                "needs the diameter of the bed; give mesh.diameter, or {name = "
                f'"{name}", D_bed = ...}}'
            )

    yield from unusable(places(closures, heat, boundary), bind)


CHECKS: tuple[Check, ...] = (
    series_are_usable,
    initial_profiles_fit_the_bed,
    tables_are_complete,
    one_solid_fills_the_bed,
    radiation_is_complete,
    tubes_see_radiation,
    solids_fit_together,
    optics_attenuate,
    heat_has_its_properties,
    a_run_in_time_has_a_start,
    heat_alone_uses_temperatures,
    names_exist,
    velocities_are_given_once,
    velocities_fit_the_mesh,
    mesh_file_exists,
    the_packing_fits_the_bed,
    profiles_lie_in_the_bed,
    gases_make_sense,
    temperatures_lie_in_the_table,
    polynomials_stay_positive,
    times_are_in_order,
    flow_has_a_way_through,
    streams_have_a_temperature,
    a_steady_temperature_is_determined,
    the_inside_of_particles_fits_the_scene,
    a_cycle_changes_something,
    the_side_of_a_line_passes_heat,
    temperatures_are_those_of_walls,
    phases_conduct_what_they_get,
    closures_exist,
)


def the_bed_has_more_than_one_cell(mesh: Mesh) -> Mistakes:
    """Look for a given number of cells that cannot show how a temperature or a
    velocity varies.
    """
    if isinstance(mesh, MeshFile) or mesh.cells is None or mesh.refine:
        return
    for k, count in enumerate(
        (mesh.cells,) if isinstance(mesh.cells, int) else mesh.cells
    ):
        if count == 1:
            path: KeyPath = (
                ("mesh", "cells")
                if isinstance(mesh, MeshLine)
                else ("mesh", "cells", k)
            )
            yield (
                path,
                "one cell cannot show how anything varies in this direction; leave out "
                "mesh.cells",
            )


def the_balance_can_fail(solver: s.Solver) -> Mistakes:
    """Look for a tolerance within which every balance closes."""
    if solver.balance_tolerance > LOOSE_BALANCE:
        yield (
            ("solver", "balance_tolerance"),
            f"allows a balance error of {solver.balance_tolerance:g} of the "
            f"total flow; results with an error above {LOOSE_BALANCE:g} are "
            "not meaningful",
        )


WARNINGS: tuple[Check, ...] = (
    the_gas_conducts_once,
    radiation_counts_once,
    solids_sum_to_one,
    two_flux_scatters_evenly,
    two_flux_is_low,
    rosseland_is_thick,
    rosseland_rests,
    initial_profiles_reach_both_ends,
    the_bed_has_more_than_one_cell,
    the_balance_can_fail,
    particles_that_melt_are_lumped,
    velocities_are_meant_as_steps,
    prescribed_temperatures_agree_in_corners,
)
