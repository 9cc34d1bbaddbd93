"""Checks of a packed bed: mistakes that remain although every single value is valid;
see `scene.checking`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from contbed.closures.packed_beds import gas_conducts_twice, unusable
from contbed.errors import SceneError
from contbed.materials.common import FAR
from contbed.packed_bed import scene as s
from contbed.packed_bed.closures import OF_HEAT, bound, places
from contbed.packed_bed.corners import prescribed_temperatures_agree_in_corners
from contbed.packed_bed.inlets import (
    bed_axis,
    enters,
    given_velocity,
    key_of,
    role,
    velocity_key,
    velocity_vector,
)
from contbed.packed_bed.schedule import KELVIN, PHASES
from contbed.packed_bed.schedule_checks import (
    NAMES,
    Boundaries,
    at_each_time,
    initial_profiles_fit_the_bed,
    initial_profiles_reach_both_ends,
)
from contbed.packed_bed.velocity_checks import (
    velocities_are_given_once,
    velocities_fit_the_mesh,
    velocities_of_files_are_steps,
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
from contbed.scene.boundary import FLUXES, conditions_of
from contbed.scene.checking import Check, Mistakes, See
from contbed.scene.gas import Gas, GasCantera, GasConstant, GasCoolProp
from contbed.scene.mesh import SIDE, Mesh, MeshFile, MeshLine
from contbed.scene.mesh_checks import (
    mesh_file_exists,
    names_exist,
    places_across,
    positions_along,
)
from contbed.scene.quantities import ClosureFile
from contbed.scene.series import ProfileFile
from contbed.scene.series_checks import (
    a_cycle_fits_its_series,
    output_times_lie_in_the_run,
    series_are_usable,
)
from contbed.scene.tables import FieldOutput
from contbed.scene.toml_lines import KeyPath, Origin, dotted

ENTERING = "temperature, or fixed_temperature"
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
            "others only radiate",
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


def heat_has_its_properties(
    heat: s.Heat | None, solids: Mapping[str, s.Solid], gas: Gas, closures: s.Closures
) -> Mistakes:
    """Check that a scene with [heat] has the properties of its solid and its gas,
    and an exchange.
    """
    if heat is None:
        return
    needs = "missing; a scene with [heat] needs it"
    for name, solid in s.that_fill_the_bed(solids).items():
        for key in ("density", "heat_capacity", "conductivity"):
            if getattr(solid, key) is None:
                yield ("solids", name, key), needs
    if closures.nusselt is None:
        yield ("closures", "nusselt"), needs
    if isinstance(gas, GasConstant):
        for key in ("heat_capacity", "conductivity"):
            if getattr(gas, key) is None:
                yield ("gas", key), needs
            elif getattr(gas, key) == 0:
                yield ("gas", key), "is 0; a scene with [heat] needs it above 0"


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


def heat_alone_uses_temperatures(
    heat: s.Heat | None,
    closures: s.Closures,
    boundary: Boundaries,
    region: Mapping[str, s.Region],
    time: s.Time | None,
    gas: Gas,
) -> Mistakes:
    """Check that a scene without [heat] has no temperatures but that of the gas which
    enters, where the properties of the gas depend on it.
    """
    if heat is not None:
        return
    remedy = "has no meaning without a [heat] table"
    for key in OF_HEAT:
        if key in closures.model_fields_set:
            yield ("closures", key), remedy
    inlet = given_velocity(boundary, "fluid")
    varies = inlet is not None and not isinstance(gas, GasConstant)
    known = False
    for name, table in boundary.items():
        for phase in PHASES:
            condition = table.thermal(phase)
            if condition is None:
                continue
            if varies and phase == "fluid" and condition.temperature is not None:
                known = True
            else:
                yield key_of(boundary, name, phase), remedy
    if varies and inlet is not None and not known:
        yield (
            ("boundary", inlet[0], "gas", "temperature"),
            "is missing: without [heat] the properties of the gas are taken at it",
        )
    for name in region:
        yield ("region", name), remedy
    if time is not None:
        yield ("time",), "needs a [heat] table: the flow is steady"


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


@at_each_time
def temperatures_lie_in_the_table(
    gas: Gas, boundary: Boundaries, initial: s.Initial, see: See
) -> Mistakes:
    """Check that the gas's temperatures lie in the range of its table."""
    if not isinstance(gas, GasCoolProp):
        return
    low, high = gas.T_range
    for path, temperature in _temperatures(["fluid"], boundary, initial):
        if low < high and not low <= temperature <= high:
            yield (
                path,
                f"outside of the gas's table, {low:g} to {high:g} K; see "
                f"{see('gas.T_range')}",
            )


@at_each_time
def polynomials_stay_positive(
    solids: Mapping[str, s.Solid], boundary: Boundaries, initial: s.Initial
) -> Mistakes:
    """Check that properties of the solid are positive at the temperatures of the
    scene.
    """
    polynomials = [
        (name, key, coefficients)
        for name, solid in s.that_fill_the_bed(solids).items()
        for key in ("heat_capacity", "conductivity")
        if isinstance(coefficients := getattr(solid, key), tuple)
    ]
    for name, key, coefficients in polynomials:
        for path, temperature in _temperatures(PHASES, boundary, initial):
            value = sum(a * temperature**power for power, a in enumerate(coefficients))
            if not value > 0:
                yield (
                    ("solids", name, key),
                    f"is {value:.4g} at {dotted(path)} = {temperature:g} K; it must be "
                    "above 0",
                )
                break


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


@at_each_time
def flow_has_a_way_through(
    mesh: Mesh, gas: Gas | None, boundary: Boundaries, see: See
) -> Mistakes:
    """Check that the flow conditions of the boundaries let the gas enter and leave."""
    velocity = velocity_vector(mesh, boundary, "fluid")
    speed = _about_velocity(boundary, "fluid", see)
    if gas is None or len(velocity) != mesh.dimension:
        return
    given = {
        name: conditions.type
        for name, conditions in boundary.items()
        if conditions.type is not None
    }
    moving = any(velocity)
    for name, kind in given.items():
        path = ("boundary", name, "type")
        if kind == "inlet" and not moving:
            yield path, f"nothing enters: the velocity is 0; {speed}"
            continue
        direction = enters(mesh, velocity, name)
        if kind == "inlet" and direction in (0, -1):
            yield path, f"the velocity does not enter through '{name}'; {speed}"
        if kind == "outlet" and direction == 1:
            yield path, f"the velocity enters through '{name}'; {speed}"
    if isinstance(mesh, MeshFile):
        roles: set[str | None] = set(given.values())
        source = given_velocity(boundary, "fluid")
        if "outlet" in roles and source is not None and source[0] not in given:
            roles.add("inlet")  # by the sign of the velocity, see `role_in_flow`
        sides = list(given)
    else:
        sides = [side for pair in mesh.sides for side in pair]
        roles = {role(mesh, velocity, side, boundary) for side in sides}
        # Roles that contradict the velocity are reported above.
        if any(
            enters(mesh, velocity, name) == {"outlet": 1, "inlet": -1}.get(kind, 2)
            for name, kind in given.items()
        ):
            return
    if not moving or not roles & {"inlet", "outlet", "no_slip", "slip"}:
        return
    for kind, other, verb in (
        ("inlet", "outlet", "enter"),
        ("outlet", "inlet", "leave"),
    ):
        if kind not in roles and (other in roles or not isinstance(mesh, MeshFile)):
            walls = [side for side in sides if given.get(side) in ("no_slip", "slip")]
            at: KeyPath = ("boundary", walls[0], "type") if walls else ("boundary",)
            remedy = f"no boundary is an {kind}; give one type = '{kind}'"
            yield at, f"the fluid cannot {verb}: {remedy}; {speed}"


@at_each_time
def streams_have_a_temperature(
    mesh: Mesh, heat: s.Heat | None, boundary: Boundaries, see: See
) -> Mistakes:
    """Check that every stream that enters has a temperature."""
    if heat is None:
        return
    for phase, what in NAMES.items():
        velocity = velocity_vector(mesh, boundary, phase)
        speed = _about_velocity(boundary, phase, see)
        if len(velocity) != mesh.dimension:
            continue
        conditions = {
            name: c
            for name, b in boundary.items()
            if (c := b.thermal(phase)) is not None
        }
        for name, condition in conditions.items():
            if condition.temperature is None:
                continue
            path = key_of(boundary, name, phase, "temperature")
            if not any(velocity):
                yield (
                    path,
                    f"the {what} does not move, so that nothing enters; use "
                    f"fixed_temperature; {speed}",
                )
            elif enters(mesh, velocity, name) in (0, -1):
                yield path, f"no {what} enters through '{name}'; {speed}"
        if isinstance(mesh, MeshFile):
            known = any(
                c.temperature is not None or c.fixed_temperature is not None
                for c in conditions.values()
            )
            if any(velocity) and not known:
                yield (
                    ("boundary",),
                    f"no boundary gives the temperature of the entering {what}: "
                    f"{ENTERING}",
                )
            continue
        for name in (
            side
            for pair in mesh.sides
            for side in pair
            if enters(mesh, velocity, side) == 1
        ):
            is_wall = (
                phase == "fluid"
                and name in boundary
                and boundary[name].type in ("slip", "no_slip")
            )
            if name not in conditions and not is_wall:
                yield (
                    key_of(boundary, name, phase),
                    f"the {what} enters here without a temperature; give {ENTERING}; "
                    f"{speed}",
                )


def a_steady_temperature_is_determined(
    mesh: Mesh,
    solids: Mapping[str, s.Solid],
    heat: s.Heat | None,
    closures: s.Closures,
    time: s.Time | None,
    boundary: Boundaries,
    radiation: Radiation | None,
) -> Mistakes:
    """Check that something determines the temperature of a steady scene."""
    if heat is None or time is not None:
        return
    insulators = _insulators(closures, solids, radiation)
    tied = set()
    for side, conditions in boundary.items():
        takers = set(PHASES)
        if conditions.whole:
            beside = isinstance(mesh, MeshLine) and side == SIDE
            takers = _takers(beside, insulators)
        for phase in takers:
            condition = conditions.condition(phase)
            if condition is not None and condition.ties:
                tied.add(phase)
    if radiation is not None and any(
        conditions.radiation for conditions in boundary.values()
    ):
        tied.add("solid")
    # Without exchange between the phases each needs a temperature of its own.
    loose = (
        [phase for phase in PHASES if phase not in tied]
        if closures.nusselt == 0 or not tied
        else []
    )
    if loose:
        yield (
            ("heat",),
            "the steady temperature of the "
            f"{' and the '.join(NAMES[phase] for phase in loose)} is undetermined: no "
            "boundary has temperature, fixed_temperature or coefficient, none "
            "radiates; give one, or a [time] table",
        )


def the_inside_of_particles_fits_the_scene(
    solids: Mapping[str, s.Solid], heat: s.Heat | None, radiation: Radiation | None
) -> Mistakes:
    """Check that particles with an inside exchange heat, and that their mean
    temperature is not what radiates.
    """
    for name, solid in solids.items():
        if solid.inside is None:
            continue
        path = ("solids", name, "inside")
        if heat is None:
            yield (
                path,
                "intraparticle conduction needs the temperatures of two phases; add a "
                "[heat] table",
            )
        elif solid.inside.heat == "interior" and radiation is not None:
            yield (
                (*path, "heat"),
                "temperatures inside are not coupled with [radiation]; use "
                '"effective", a film coefficient corrected '
                "for conduction inside",
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


def the_side_of_a_line_passes_heat(mesh: Mesh, boundary: Boundaries) -> Mistakes:
    """Check that the side of a line passes heat, and nothing else."""
    side = boundary.get(SIDE) if isinstance(mesh, MeshLine) else None
    if side is None:
        return
    for key in ("type", "radiation"):
        if getattr(side, key) is not None:
            yield ("boundary", SIDE, key), "has no meaning on the side of a line"
    heat_alone = (
        "only heat passes through the side of a line; give coefficient and ambient, or "
        "heat_flux"
    )
    if side.temperature is not None:
        yield ("boundary", SIDE, "temperature"), heat_alone
        return
    for path, _, condition in conditions_of({SIDE: side}):
        for key in ("velocity", "temperature", "fixed_temperature"):
            if getattr(condition, key) is not None:
                yield (*path, key), heat_alone


def temperatures_are_those_of_walls(mesh: Mesh, boundary: Boundaries) -> Mistakes:
    """Check that a temperature of the whole bed is that of a wall."""
    for name, table in boundary.items():
        beside = isinstance(mesh, MeshLine) and name == SIDE
        ends = table.type in (None, "inlet", "outlet")
        if table.temperature is not None and ends and not beside:
            yield (
                ("boundary", name, "temperature"),
                "that of a wall, which both phases take: give "
                'type = "wall" with it; gas.temperature is that of a stream',
            )


def phases_conduct_what_they_get(
    mesh: Mesh,
    closures: s.Closures,
    boundary: Boundaries,
    solids: Mapping[str, s.Solid],
    radiation: Radiation | None,
) -> Mistakes:
    """Check that heat enters no phase through a boundary from which that phase cannot
    conduct it: it would heat the cells at the boundary alone, whatever their size.
    """
    phases, insulators = {"gas", *solids}, _insulators(closures, solids, radiation)
    for path, phase, condition in conditions_of(boundary):
        side = str(path[1])
        takers = phases if boundary[side].passes_heat else {phase}
        beside = isinstance(mesh, MeshLine) and side == SIDE
        if beside or not takers <= set(insulators):
            continue
        zero = sorted({f"{insulators[taker]} = 0" for taker in takers})
        for key in FLUXES:
            if not getattr(condition, key):
                continue
            remedy = "give a phase a conductivity"
            if phases - set(insulators):
                table = "gas" if phase != "gas" else f"solids.{next(iter(solids))}"
                of_bed = key in s.Boundary.model_fields
                remedy = f"give boundary.{side}{'' if of_bed else '.' + table}.{key}"
            yield (
                (*path, key),
                f"no heat passes from '{side}' into the bed with "
                f"{' and '.join(zero)}; {remedy}",
            )


def _takers(beside_a_line: bool, insulators: Iterable[str]) -> set[str]:
    """Return the phases, "fluid" and "solid", that take heat given for the whole bed."""
    if beside_a_line:
        return {"fluid"}
    idle = {"fluid" if name == "gas" else "solid" for name in insulators}
    return set(PHASES) - idle


def _insulators(
    closures: s.Closures, solids: Mapping[str, s.Solid], radiation: Radiation | None
) -> dict[str, str]:
    """Return the phases that do not conduct, with the keys of their conductivities."""
    if closures.tortuosity is not None:
        return {}
    found = {}
    if closures.conductivity_gas == 0.0 and closures.dispersion is None:
        found["gas"] = "closures.conductivity_gas"
    as_conduction = radiation is not None and radiation.level == "rosseland"
    if closures.conductivity_solids == 0.0 and not as_conduction:
        found |= dict.fromkeys(solids, "closures.conductivity_solids")
    return found


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


def particles_that_melt_are_lumped(solids: Mapping[str, s.Solid]) -> Mistakes:
    """Look for intraparticle conduction where particles melt."""
    for name, solid in solids.items():
        inside = solid.inside
        if solid.melting is not None and inside is not None and inside.heat != "lumped":
            yield (
                ("solids", name, "inside", "heat"),
                "intraparticle conduction takes the heat capacity at the mean temperature of "
                "a particle; the front of melting within it is not resolved",
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


def the_gas_conducts_once(
    closures: s.Closures, heat: s.Heat | None, origin: Origin
) -> Mistakes:
    """Look for a closure of the whole bed at rest beside the conductivity of its
    gas.
    """
    if heat is not None:
        yield from gas_conducts_twice(("closures",), closures, origin.base)


WARNINGS: tuple[Check, ...] = (
    the_gas_conducts_once,
    solids_sum_to_one,
    two_flux_scatters_evenly,
    two_flux_is_low,
    rosseland_is_thick,
    rosseland_rests,
    initial_profiles_reach_both_ends,
    the_bed_has_more_than_one_cell,
    the_balance_can_fail,
    particles_that_melt_are_lumped,
    velocities_of_files_are_steps,
    prescribed_temperatures_agree_in_corners,
)


def _about_velocity(boundary: Boundaries, phase: str, see: See) -> str:
    """Say where the velocity of a phase stands."""
    if given_velocity(boundary, phase) is None:
        key = "gas.velocity" if phase == "fluid" else "solids.NAME.velocity"
        return f"no boundary gives {key}"
    return f"see {see(velocity_key(boundary, phase))}"


def require_properties(fluid: Any, scene: s.Scene) -> None:
    """Refuse temperatures so far from the data of the gas that no property is left.

    Raises
    ------
    SceneError : a property is not positive there, or the data are too far away
    """
    low, high = fluid.T_range
    for path, T in _temperatures(["fluid"], scene.boundary, scene.initial):
        of = (fluid.heat_capacity, fluid.viscosity, fluid.conductivity)
        if low - FAR > T or not all(each(T) > 0.0 for each in of):
            raise SceneError(
                f"{scene.origin.place(path)}: {T:g} K is too far from the "
                f"data of {fluid.name}, {low:g} to {high:g} K"
            )


def _temperatures(
    phases: Iterable[str], boundary: Boundaries, initial: s.Initial
) -> Iterator[tuple[KeyPath, float]]:
    """Yield the key and value of every temperature that the scene gives for these
    phases; none of a file.
    """
    for phase in phases:
        for name, table in boundary.items():
            condition = table.condition(phase)
            for key in KELVIN:
                value = getattr(condition, key, None)
                if value is not None:
                    yield key_of(boundary, name, phase, key), value
        given = initial.given(phase)
        if given is not None and not isinstance(given, ProfileFile):
            yield initial.key(phase), given
