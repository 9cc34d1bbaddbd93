"""Checks of a packed bed: mistakes that remain although every single value is valid; see `scene.checking`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from contbed.closures.binding import is_phase, named
from contbed.closures.fluid_conducts import fluid_conducts_twice
from contbed.errors import SceneError
from contbed.packed_bed import scene as s
from contbed.packed_bed.closures import GIVES, bound, places
from contbed.packed_bed.corners import prescribed_temperatures_agree_in_corners
from contbed.packed_bed.inlets import enters, role, velocity_vector
from contbed.packed_bed.schedule import series_of
from contbed.packed_bed.schedule_checks import (
    PHASES,
    Boundaries,
    at_each_time,
    initial_profiles_fit_the_bed,
    initial_profiles_reach_both_ends,
    series_are_usable,
)
from contbed.radiation.checks import (
    particles_have_a_size_and_fit_together,
    radiation_is_complete,
    species_fill_the_solids,
    tubes_see_radiation,
    two_flux_scatters_evenly,
)
from contbed.radiation.scene import Radiation
from contbed.radiation.thickness import rosseland_is_thick, rosseland_rests
from contbed.scene.checking import Check, Mistakes, See
from contbed.scene.mesh import Mesh, MeshAxisymmetric, MeshFile, MeshLine
from contbed.scene.mesh_checks import (
    mesh_file_exists,
    names_exist,
    positions_lie_in_the_bed,
    the_line_of_profiles_fits_the_mesh,
)
from contbed.scene.quantities import ClosureFile
from contbed.scene.series import ProfileFile
from contbed.scene.series_checks import a_cycle_fits_its_series
from contbed.scene.tables import Closure, Fluid, FluidCantera, FluidConstant, FluidCoolProp, Solid, Solver
from contbed.scene.toml_lines import KeyPath, Origin, dotted

LOOSE_BALANCE = 1e-3  # tolerance of a balance above which a warning is given: the accuracy that engineers ask for


def tables_are_complete(
    heat: s.Heat | None, radiation: Radiation | None, fluid: Fluid | None, bed: s.Bed | None, flow: s.Flow | None
) -> Mistakes:
    """Check that the tables that belong together are present."""
    alone = heat is None and radiation is not None
    for name, table in (("fluid", fluid), ("bed", bed), ("flow", flow)):
        if table is None and not alone:
            yield (name,), f"this table is missing; {'[heat]' if heat is not None else 'the flow'} needs it"
        elif table is not None and alone and name != "bed":
            yield (name,), "has no meaning with [radiation] alone; add [heat] or remove it"


def heat_has_its_materials(heat: s.Heat | None, solid: Solid | None, fluid: Fluid) -> Mistakes:
    """Check that a scene with [heat] has a solid and the properties of its fluid."""
    if heat is None:
        return
    if solid is None:
        yield ("heat",), "needs a [solid] table with density, heat_capacity and conductivity"
    if isinstance(fluid, FluidConstant):
        for name in ("heat_capacity", "conductivity"):
            if getattr(fluid, name) is None:
                yield ("fluid", name), "missing; a scene with [heat] needs it"
            elif getattr(fluid, name) == 0:
                yield ("fluid", name), "is 0; a scene with [heat] needs it above 0"


def heat_alone_uses_temperatures(
    heat: s.Heat | None, boundary: Boundaries, region: Mapping[str, s.Region], time: s.Time | None
) -> Mistakes:
    """Check that no temperatures are given in a scene without [heat]."""
    if heat is not None:
        return
    remedy = "has no meaning without a [heat] table"
    for name, conditions in boundary.items():
        for phase in PHASES:
            if getattr(conditions, phase) is not None:
                yield ("boundary", name, phase), remedy
    for name in region:
        yield ("region", name), remedy
    if time is not None:
        yield ("time",), "needs a [heat] table: the flow is steady"


@at_each_time
def velocities_fit_the_mesh(mesh: Mesh, flow: s.Flow, see: See) -> Mistakes:
    """Check that velocities have as many components as the mesh has dimensions."""
    for key in PHASES.values():
        value = getattr(flow, key)
        if not isinstance(value, tuple):
            continue
        if len(value) != mesh.dimension:
            yield (
                ("flow", key),
                f"has {len(value)} components, the mesh has {mesh.dimension} dimensions; see {see('mesh.type')}",
            )
        elif isinstance(mesh, MeshAxisymmetric) and value[0] != 0:
            yield ("flow", key), f"the radial velocity is 0 in an axisymmetric bed; see {see('mesh.type')}"


def the_packing_fits_the_bed(mesh: Mesh, bed: s.Bed, see: See) -> Mistakes:
    """Check that the particles are smaller than a built-in bed."""
    if isinstance(mesh, MeshFile):
        return
    if bed.particle_diameter > mesh.length:
        yield (
            ("bed", "particle_diameter"),
            f"{bed.particle_diameter:g} m is more than the length of the bed, {see('mesh.length')}; is a unit missing?",
        )


def fluids_make_sense(fluid: Fluid) -> Mistakes:
    """Check the temperature range and the composition of the fluid."""
    if isinstance(fluid, FluidCoolProp) and fluid.T_range[0] >= fluid.T_range[1]:
        yield ("fluid", "T_range"), "the lower temperature comes first"
    if isinstance(fluid, FluidCantera):
        from contbed.materials.composition import require_sum

        try:
            require_sum(fluid.composition)
        except SceneError as error:
            yield ("fluid", "composition"), str(error)


@at_each_time
def temperatures_lie_in_the_fluid_table(fluid: Fluid, boundary: Boundaries, time: s.Time | None, see: See) -> Mistakes:
    """Check that the fluid's temperatures lie in the range of its table."""
    if not isinstance(fluid, FluidCoolProp):
        return
    low, high = fluid.T_range
    for path, temperature in _temperatures(["fluid"], boundary, time):
        if low < high and not low <= temperature <= high:
            yield path, f"outside of the fluid's table, {low:g} to {high:g} K; see {see('fluid.T_range')}"


@at_each_time
def polynomials_stay_positive(solid: Solid | None, boundary: Boundaries, time: s.Time | None) -> Mistakes:
    """Check that properties of the solid are positive at the temperatures of the scene."""
    if solid is None:
        return
    for key in ("heat_capacity", "conductivity"):
        coefficients = getattr(solid, key)
        if not isinstance(coefficients, tuple):
            continue
        for path, temperature in _temperatures(PHASES, boundary, time):
            value = sum(a * temperature**power for power, a in enumerate(coefficients))
            if not value > 0:
                yield ("solid", key), f"is {value:.4g} at {dotted(path)} = {temperature:g} K; it must be above 0"
                break


def times_are_in_order(time: s.Time | None, see: See) -> Mistakes:
    """Check that output times and steps lie within the run."""
    if time is None:
        return
    for index, instant in enumerate(time.times):
        if instant in time.times[:index]:
            yield ("time", "times", index), f"{instant:g} s is given twice"
        if instant > time.end:
            yield ("time", "times", index), f"{instant:g} s is after the end; see {see('time.end')}"
    if time.step is not None and time.step > time.end:
        yield ("time", "step"), f"{time.step:g} s is more than the whole run; see {see('time.end')}"
    if time.step is not None and "tolerance" in time.model_fields_set:
        yield ("time", "tolerance"), f"has no meaning with a fixed step; remove one; see {see('time.step')}"


@at_each_time
def flow_has_a_way_through(mesh: Mesh, flow: s.Flow, boundary: Boundaries, see: See) -> Mistakes:
    """Check that the flow conditions of the boundaries let the fluid enter and leave."""
    velocity = velocity_vector(mesh, flow.velocity)
    if len(velocity) != mesh.dimension:
        return
    given = {name: conditions.type for name, conditions in boundary.items() if conditions.type is not None}
    moving = any(velocity)
    for name, kind in given.items():
        path = ("boundary", name, "type")
        if kind == "inlet" and not moving:
            yield path, f"nothing enters: the velocity is 0; see {see('flow.velocity')}"
            continue
        direction = enters(mesh, velocity, name)
        if kind == "inlet" and direction in (0, -1):
            yield path, f"the velocity does not enter through '{name}'; see {see('flow.velocity')}"
        if kind == "outlet" and direction == 1:
            yield path, f"the velocity enters through '{name}'; see {see('flow.velocity')}"
    if isinstance(mesh, MeshFile):
        roles: set[str | None] = set(given.values())
        sides = list(given)
    else:
        sides = [side for pair in mesh.sides for side in pair]
        roles = {role(mesh, velocity, side, boundary) for side in sides}
        # Roles that contradict the velocity are reported above.
        if any(enters(mesh, velocity, name) == {"outlet": 1, "inlet": -1}.get(kind, 2) for name, kind in given.items()):
            return
    if not moving or not roles & {"inlet", "outlet", "no_slip", "slip"}:
        return
    for kind, other, verb in (("inlet", "outlet", "enter"), ("outlet", "inlet", "leave")):
        if kind not in roles and (other in roles or not isinstance(mesh, MeshFile)):
            walls = [side for side in sides if given.get(side) in ("no_slip", "slip")]
            at: KeyPath = ("boundary", walls[0], "type") if walls else ("boundary",)
            remedy = f"no boundary is an {kind}; give one type = '{kind}'"
            yield at, f"the fluid cannot {verb}: {remedy}; see {see('flow.velocity')}"


@at_each_time
def streams_have_a_temperature(
    mesh: Mesh, flow: s.Flow, heat: s.Heat | None, boundary: Boundaries, see: See
) -> Mistakes:
    """Check that every stream that enters has a temperature."""
    if heat is None:
        return
    for phase, key in PHASES.items():
        velocity = velocity_vector(mesh, getattr(flow, key))
        if len(velocity) != mesh.dimension:
            continue
        conditions = {name: getattr(b, phase) for name, b in boundary.items() if getattr(b, phase) is not None}
        for name, condition in conditions.items():
            if condition.inflow is None:
                continue
            path = ("boundary", name, phase, "inflow")
            if not any(velocity):
                yield path, f"the {phase} does not move, so that nothing enters; use fixed; see {see(f'flow.{key}')}"
            elif enters(mesh, velocity, name) in (0, -1):
                yield path, f"no {phase} enters through '{name}'; see {see(f'flow.{key}')}"
        if isinstance(mesh, MeshFile):
            known = any(c.inflow is not None or c.fixed is not None for c in conditions.values())
            if any(velocity) and not known:
                yield ("boundary",), f"no boundary gives the temperature of the entering {phase}: inflow, or fixed"
            continue
        for name in (side for pair in mesh.sides for side in pair if enters(mesh, velocity, side) == 1):
            is_wall = phase == "fluid" and name in boundary and boundary[name].type in ("slip", "no_slip")
            if name not in conditions and not is_wall:
                yield (
                    ("boundary", name, phase),
                    f"the {phase} enters here without a temperature; give inflow, or fixed; see {see(f'flow.{key}')}",
                )


def a_steady_temperature_is_determined(
    heat: s.Heat | None, time: s.Time | None, boundary: Boundaries, radiation: Radiation | None
) -> Mistakes:
    """Check that something determines the temperature of a steady scene."""
    if heat is None or time is not None:
        return
    tied = {
        phase
        for conditions in boundary.values()
        for phase in PHASES
        if (c := getattr(conditions, phase)) is not None and c.ties
    }
    if radiation is not None and any(conditions.radiation for conditions in boundary.values()):
        tied.add("solid")
    # Without exchange between the phases each needs a temperature of its own.
    loose = [phase for phase in PHASES if phase not in tied] if heat.nusselt == 0 or not tied else []
    if loose:
        yield (
            ("heat",),
            f"the steady temperature of the {' and the '.join(loose)} is undetermined: no boundary has fixed, inflow "
            "or coefficient, none radiates; give one, or a [time] table",
        )


def the_inside_of_particles_fits_the_scene(
    particle: s.Particle | None, heat: s.Heat | None, radiation: Radiation | None
) -> Mistakes:
    """Check that particles with an inside exchange heat, and that their mean temperature is not what radiates."""
    if particle is None:
        return
    if heat is None:
        yield ("particle",), "intraparticle conduction needs the temperatures of two phases; add a [heat] table"
    elif particle.heat == "interior" and radiation is not None:
        yield (
            ("particle", "heat"),
            'temperatures inside are not coupled with [radiation]; use "effective", a film coefficient corrected for '
            "conduction inside",
        )


def a_cycle_changes_something(
    time: s.Time | None, flow: s.Flow | None, boundary: Boundaries, mesh: Mesh, see: See
) -> Mistakes:
    """Check that a cycle has series, without which nothing changes in the course of a period."""
    if time is None or time.cycle is None:
        return
    yield from a_cycle_fits_its_series(series_of(flow, boundary), time, "a velocity or a temperature", see)
    if not isinstance(mesh, MeshLine):
        yield ("time", "cycle"), 'the cyclic steady state is found on a line; use mesh.type = "line"'


def closures_exist(mesh: Mesh, bed: s.Bed, heat: s.Heat | None, boundary: Boundaries, origin: Origin) -> Mistakes:
    """Check that the closures exist and that the bed has the arguments that they need."""
    for path, spec, kind in places(bed, heat, boundary):
        if not named(spec):
            continue
        if kind == "conductivity" and is_phase(spec):
            if isinstance(spec, Closure) and spec.model_extra:
                yield path, f"{spec.name} has no parameters"
            continue
        try:
            found = bound(spec, kind, origin.base)
        except SceneError as error:
            yield path, str(error)
            continue
        if isinstance(mesh, MeshLine) and "D_bed" in found.takes and not isinstance(spec, ClosureFile):
            name = spec if isinstance(spec, str) else spec.name
            yield path, f'needs the diameter of the bed, which a line does not have: {{name = "{name}", D_bed = ...}}'


CHECKS: tuple[Check, ...] = (
    series_are_usable,
    initial_profiles_fit_the_bed,
    tables_are_complete,
    radiation_is_complete,
    tubes_see_radiation,
    particles_have_a_size_and_fit_together,
    heat_has_its_materials,
    heat_alone_uses_temperatures,
    names_exist,
    velocities_fit_the_mesh,
    mesh_file_exists,
    the_packing_fits_the_bed,
    positions_lie_in_the_bed,
    the_line_of_profiles_fits_the_mesh,
    fluids_make_sense,
    temperatures_lie_in_the_fluid_table,
    polynomials_stay_positive,
    times_are_in_order,
    flow_has_a_way_through,
    streams_have_a_temperature,
    a_steady_temperature_is_determined,
    the_inside_of_particles_fits_the_scene,
    a_cycle_changes_something,
    closures_exist,
)


def the_bed_has_more_than_one_cell(mesh: Mesh) -> Mistakes:
    """Look for a given number of cells that cannot show how a temperature or a velocity varies."""
    if isinstance(mesh, MeshFile) or mesh.cells is None or mesh.refine:
        return
    for k, count in enumerate((mesh.cells,) if isinstance(mesh.cells, int) else mesh.cells):
        if count == 1:
            path: KeyPath = ("mesh", "cells") if isinstance(mesh, MeshLine) else ("mesh", "cells", k)
            yield path, "one cell cannot show how anything varies in this direction; leave out mesh.cells"


def the_balance_can_fail(solver: Solver) -> Mistakes:
    """Look for a tolerance within which every balance closes."""
    if solver.balance_tolerance > LOOSE_BALANCE:
        yield (
            ("solver", "balance_tolerance"),
            f"{solver.balance_tolerance:g} of what crosses and is released may be missing; results with a balance open "
            f"by more than {LOOSE_BALANCE:g} mean little",
        )


def the_fluid_conducts_once(heat: s.Heat | None, origin: Origin) -> Mistakes:
    """Look for a closure of the whole bed at rest beside the conductivity of its fluid."""
    if heat is not None:
        solid = ("heat", "conductivity_solid"), heat.conductivity_solid
        fluid = ("heat", "conductivity_fluid"), heat.conductivity_fluid
        yield from fluid_conducts_twice(solid, fluid, GIVES["conductivity"], origin.base)


WARNINGS: tuple[Check, ...] = (
    the_fluid_conducts_once,
    species_fill_the_solids,
    two_flux_scatters_evenly,
    rosseland_is_thick,
    rosseland_rests,
    initial_profiles_reach_both_ends,
    the_bed_has_more_than_one_cell,
    the_balance_can_fail,
    prescribed_temperatures_agree_in_corners,
)


def _temperatures(phases: Iterable[str], boundary: Boundaries, time: s.Time | None) -> Iterator[tuple[KeyPath, float]]:
    """Yield the key and value of every temperature that the scene gives for these phases; none of a file."""
    for phase in phases:
        for name, conditions in boundary.items():
            condition = getattr(conditions, phase)
            for key in ("fixed", "inflow", "ambient"):
                if condition is not None and getattr(condition, key) is not None:
                    yield ("boundary", name, phase, key), getattr(condition, key)
        given = None if time is None else getattr(time, f"initial_{phase}")
        if given is not None and not isinstance(given, ProfileFile):
            yield ("time", f"initial_{phase}"), given
