"""What is wrong with a two-fluid scene although every single value is right."""

from __future__ import annotations

from itertools import combinations
from math import prod

from contbed.closures import names, sheet
from contbed.closures.binding import bind, named
from contbed.errors import SceneError
from contbed.scene import mesh as meshes
from contbed.scene.checking import Mistakes, See
from contbed.scene.quantities import Table
from contbed.scene.toml_lines import Origin
from contbed.two_fluid import near_walls
from contbed.two_fluid import scene as t
from contbed.two_fluid.closures import (
    ABSENT,
    FROM_CELLS,
    GIVES,
    HEAT_KINDS,
    KINDS,
    full_name,
    is_filtered_stress,
    settling_velocity,
    takes,
)
from contbed.two_fluid.heat.scene import Heat, conducts
from contbed.two_fluid.warnings import WARNINGS as WARNINGS

MIN_PRESSURE = 1e3  # [Pa] of an ideal gas; below, its mean free path is no longer small beside the particles
SAME_THETA = 1e-3  # share by which a granular temperature may be rounded in a scene
MAX_TEMPERATURE = 6000.0  # [K]; above, gases dissociate and no particle is solid


def mesh_has_cells(mesh: meshes.Mesh, origin: Origin) -> Mistakes:
    """Check that the mesh is a file that exists or has a number of cells."""
    if isinstance(mesh, meshes.MeshFile):
        if not (origin.base / mesh.file).is_file():
            yield ("mesh", "file"), f"no such file; looked for {(origin.base / mesh.file).absolute()}"
    elif mesh.cells is None:
        yield ("mesh", "cells"), "missing; a two-fluid model has no layers to grade a mesh by"
    elif mesh.refine == 0 and (mesh.cells if isinstance(mesh.cells, int) else prod(mesh.cells)) == 1:
        yield ("mesh", "cells"), "one cell has no neighbour to exchange anything with; give at least 2"


def layers_are_in_the_vessel(initial: t.Initial, mesh: meshes.Mesh) -> Mistakes:
    """Check that each layer is in the vessel, and that no two layers set the same field at the same place."""
    for k, layer in enumerate(initial.layer):
        if layer.end <= 0.0 and not isinstance(mesh, meshes.MeshFile):
            yield ("initial", "layer", k, "end"), "the vessel begins at 0 m; nothing of the layer is in it"
        if not isinstance(mesh, meshes.MeshFile) and layer.start >= mesh.extents[-1]:
            text = f"the vessel ends at {mesh.extents[-1]:.6g} m; nothing of the layer is in it"
            yield ("initial", "layer", k, "start"), text
    for (i, first), (k, second) in combinations(enumerate(initial.layer), 2):
        fields = sorted(first.model_fields_set & second.model_fields_set - {"start", "end"})
        if fields and max(first.start, second.start) < min(first.end, second.end):
            text = f"overlaps layer {i + 1}, which sets {', '.join(fields)} there too; change start and end"
            yield ("initial", "layer", k), text


def pieces_do_not_overlap(boundary: dict[str, t.Boundary]) -> Mistakes:
    """Check that no two pieces of a boundary overlap."""
    pieces = [
        (name, part)
        for name, part in boundary.items()
        if not isinstance(part, t.Periodic) and part.on is not None and part.start is not None and part.end is not None
    ]
    for (first, one), (second, other) in combinations(pieces, 2):
        assert one.start is not None and one.end is not None and other.start is not None and other.end is not None
        if one.on == other.on and max(one.start, other.start) < min(one.end, other.end):
            yield ("boundary", second, "start"), f"overlaps boundary.{first}, also a piece of {one.on!r}"


def particles_fit_the_mesh(solid: t.Solid, mesh: meshes.Mesh, see: See) -> Mistakes:
    """Check that a particle has room in the vessel."""
    if not isinstance(mesh, meshes.MeshFile) and solid.particle_diameter >= min(mesh.extents):
        text = f"no smaller than the vessel, which is {min(mesh.extents):.4g} m wide; see {see('mesh')}"
        yield ("solid", "particle_diameter"), text


def window_is_in_the_vessel(output: t.Output, mesh: meshes.Mesh) -> Mistakes:
    """Check that the window of averages lies in the vessel."""
    if (window := output.window) is None:
        return
    if window.start >= window.end:
        yield ("output", "window", "end"), "is not above start"
    elif not isinstance(mesh, meshes.MeshFile) and (window.end <= 0.0 or window.start >= mesh.extents[-1]):
        yield ("output", "window"), f"outside of the vessel, which reaches from 0 to {mesh.extents[-1]:.6g} m"


def levels_are_in_the_vessel(output: t.Output, mesh: meshes.Mesh) -> Mistakes:
    """Check that the heights of lateral profiles lie in the vessel."""
    if isinstance(mesh, meshes.MeshFile):
        return
    for k, level in enumerate(output.levels):
        if not 0.0 <= level < mesh.extents[-1]:
            yield (
                ("output", "levels", k),
                f"outside of the vessel, which reaches from 0 to {mesh.extents[-1]:.6g} m",
            )


def closures_exist(two_fluid: t.TwoFluid, origin: Origin) -> Mistakes:
    """Check that every closure of [two_fluid] exists and can be called."""
    for key, kind in KINDS.items():
        chosen = getattr(two_fluid, key)
        if chosen == ABSENT:
            if kind in ("radial_distribution", "granular_pressure"):
                yield ("two_fluid", key), 'cannot be "none"; without collisions: pressure = "granular_pressure_dilute"'
            continue
        try:
            bind(chosen, kind, (*GIVES[kind], *FROM_CELLS.get(kind, ())), origin.base)
        except SceneError as error:
            yield ("two_fluid", key), str(error)


def friction_of_particles_is_complete(two_fluid: t.TwoFluid, solid: t.Solid, see: See, origin: Origin) -> Mistakes:
    """Check that the friction of particles has its closure, the closure its coefficient, and that both fit."""
    chosen, friction = two_fluid.effective_restitution, solid.sliding_friction
    kind = "effective_restitution"
    if chosen == ABSENT:
        if friction is not None:
            text = f"does nothing without two_fluid.{kind}; name one of {', '.join(names(kind))}, or leave it out"
            yield ("solid", "sliding_friction"), text
        return
    if two_fluid.dissipation == ABSENT:
        yield ("two_fluid", kind), f"stands in the dissipation, which is absent; see {see('two_fluid.dissipation')}"
    if friction is None:
        yield ("two_fluid", kind), "needs solid.sliding_friction, Coulomb's coefficient of two particles"
        return
    try:
        value = float(bind(chosen, kind, GIVES[kind], origin.base)(e=solid.restitution, sliding_friction=friction))
    except SceneError:
        return  # closures_exist reports it
    if not 0.0 <= value <= 1.0:
        text = f"gives {value:.4g}, no restitution between 0 and 1; see {see('solid.sliding_friction')}"
        yield ("two_fluid", kind), f"{text} and {see('solid.restitution')}"


def filtered_closures_have_their_velocity(
    two_fluid: t.TwoFluid, gas: t.Gas, solid: t.Solid, initial: t.Initial, see: See
) -> Mistakes:
    """Check that particles settle, and that the filtered stress has the granular temperature that it is given over."""
    settling = settling_velocity(two_fluid, gas, solid)
    keys = [key for key, kind in KINDS.items() if kind in FROM_CELLS and takes(getattr(two_fluid, key), kind)]
    if settling <= 0.0:
        for key in keys:
            yield ("two_fluid", key), f"needs particles that settle; see {see('two_fluid.gravity')} and the densities"
        return
    if not is_filtered_stress(two_fluid):
        return
    if two_fluid.granular_temperature != "frozen":
        yield ("two_fluid", "granular_temperature"), 'must be "frozen": the filtered stress takes its place'
    layers = [layer.theta for layer in initial.layer if layer.theta is not None]
    if any(abs(theta / settling**2 - 1.0) > SAME_THETA for theta in (initial.theta, *layers)):
        text = (
            f"must be {settling**2:.6g} m2/s2, the square of the terminal velocity, which the filtered stress is over"
        )
        yield ("initial", "theta"), text


def factors_near_walls_have_what_they_multiply(two_fluid: t.TwoFluid, gas: t.Gas, solid: t.Solid) -> Mistakes:
    """Check that factors near walls multiply filtered closures, of particles that settle."""
    for key in near_walls.KINDS:
        if getattr(two_fluid, key) == ABSENT:
            continue
        of = key.removeprefix("wall_")
        name = full_name(getattr(two_fluid, of), KINDS[of])
        absent = getattr(two_fluid, of) == ABSENT
        if absent or (name in names(KINDS[of]) and "filter_froude" not in sheet(name).arguments):
            there = ABSENT if absent else name
            yield ("two_fluid", key), f"multiplies a filtered {of}, but two_fluid.{of} is {there!r}: leave it out"
        if settling_velocity(two_fluid, gas, solid) <= 0.0:
            yield ("two_fluid", key), "needs particles that settle, under gravity and heavier than the gas"


def fractions_fit(initial: t.Initial, boundary: dict[str, t.Boundary], solid: t.Solid, see: See) -> Mistakes:
    """Check that fractions and the onset of friction are below the packing limit, and that layers have a height."""
    known = see("solid.packing")
    if initial.eps_s * (1.0 + initial.noise) > solid.packing:
        yield ("initial", "eps_s"), f"denser than the densest packing with its noise; see {known}"
    for k, layer in enumerate(initial.layer):
        if layer.eps_s is not None and layer.eps_s * (1.0 + initial.noise) > solid.packing:
            yield ("initial", "layer", k, "eps_s"), f"denser than the densest packing with its noise; see {known}"
        if layer.start >= layer.end:
            yield ("initial", "layer", k, "end"), "is not above start"
    for name, part in boundary.items():
        if isinstance(part, t.Inlet) and part.eps_s > solid.packing:
            yield ("boundary", name, "eps_s"), f"denser than the densest packing; see {known}"
    if solid.friction.start >= solid.packing:
        yield ("solid", "friction", "start"), f"is not below the densest packing; see {known}"


def boundaries_are_complete(boundary: dict[str, t.Boundary], mesh: meshes.Mesh) -> Mistakes:
    """Check that each side of the mesh has one condition, and conditions what they need."""
    sides = () if isinstance(mesh, meshes.MeshFile) else tuple(name for pair in mesh.sides for name in pair)
    partners = {part.partner for part in boundary.values() if isinstance(part, t.Periodic)}
    for name, part in boundary.items():
        where = ("boundary", name)
        whole = getattr(part, "on", None)
        if whole is not None and (part.start is None or part.end is None or part.start >= part.end):  # type: ignore[union-attr]
            yield where, f"a piece of {whole!r} needs start and end, start below end"
        if sides and (whole or name) not in sides:
            yield where, f"the mesh has no boundary {whole or name!r}; it has {', '.join(sides)}"
        if isinstance(part, t.Periodic) and sides and part.partner not in sides:
            yield (*where, "partner"), f"the mesh has no such boundary; it has {', '.join(sides)}"
        if name in partners:
            yield where, "is the partner of a periodic boundary and cannot be given twice"
        if isinstance(part, t.Wall) and (part.solid == "johnson_jackson") != (part.specularity is not None):
            yield (*where, "specularity"), "belongs to solid = 'johnson_jackson', which needs it"
        if isinstance(part, t.Wall) and part.friction and part.solid != "johnson_jackson":
            yield (*where, "friction"), "belongs to solid = 'johnson_jackson'; elsewhere particles stick or slip freely"
        if isinstance(part, t.Inlet):
            if part.solid_flux is not None and part.solid_velocity is not None:
                yield (*where, "solid_velocity"), "give either solid_flux or solid_velocity"
            if (part.eps_s > 0) != (part.solid_flux is not None or part.solid_velocity is not None):
                yield where, "particles need eps_s and either solid_flux or solid_velocity"
    for side in sides:
        if side not in boundary and side not in partners and side != "axis":
            yield ("boundary", side), "missing; every side of the mesh needs a condition"


def what_enters_can_leave(boundary: dict[str, t.Boundary]) -> Mistakes:
    """Check that there is an outlet where something enters."""
    inlets = [name for name, part in boundary.items() if isinstance(part, t.Inlet)]
    if inlets and not any(isinstance(part, t.Outlet) for part in boundary.values()):
        yield ("boundary", inlets[0]), "enters but nothing leaves; one boundary has to be of type 'outlet'"


def inlets_blow(boundary: dict[str, t.Boundary]) -> Mistakes:
    """Check that the velocity of an inlet without particles is given."""
    for name, part in boundary.items():
        if isinstance(part, t.Inlet) and part.eps_s == 0.0 and "velocity" not in part.model_fields_set:
            yield ("boundary", name, "velocity"), "missing; nothing enters (a closed boundary has type = 'wall')"


def pulses_end_in_an_inlet(boundary: dict[str, t.Boundary]) -> Mistakes:
    """Check that an inlet that ends is a piece of one that does not."""
    for name, part in boundary.items():
        if isinstance(part, t.Inlet) and part.until is not None:
            whole = boundary.get(part.on or "")
            if not isinstance(whole, t.Inlet) or whole.until is not None:
                yield ("boundary", name, "until"), "belongs to a piece `on` an inlet that does not end itself"


def heat_is_complete(
    heat: Heat | None, initial: t.Initial, boundary: dict[str, t.Boundary], time: t.Time, see: See
) -> Mistakes:
    """Check that temperatures are given where there is heat, and only there."""
    places: list[tuple[tuple[str | int, ...], Table]] = [(("initial",), initial)]
    places += [(("initial", "layer", k), layer) for k, layer in enumerate(initial.layer)]
    places += [(("boundary", name), part) for name, part in boundary.items()]
    if heat is None:
        for where, part in places:
            for key in ("T_gas", "T_solid", "T", "heat_flux"):
                if getattr(part, key, None) is not None:
                    yield (*where, key), "has no meaning without [heat]"
        return
    if initial.T_gas is None:
        yield ("initial", "T_gas"), "missing; [heat] needs it"
    for name, part in boundary.items():
        if isinstance(part, t.Inlet) and part.T_gas is None and (part.velocity > 0 or part.T_solid is None):
            yield ("boundary", name, "T_gas"), "missing; [heat] needs it"
        if isinstance(part, t.Wall) and part.T is not None:
            if part.heat_flux is not None:
                yield ("boundary", name, "heat_flux"), "give either T or heat_flux"
            if not conducts(heat):
                yield ("boundary", name, "T"), "heats nothing without conductivity_bed or effective_... in [heat]"
    if time.order == 2:
        yield ("time", "order"), f"heat is of first order in time; see {see('heat')}"


def closures_of_heat_exist(heat: Heat | None, origin: Origin) -> Mistakes:
    """Check that the closures of [heat] exist and can be called."""
    for key, kind in HEAT_KINDS.items() if heat is not None else ():
        chosen = getattr(heat, key)
        if not named(chosen):
            continue
        try:
            bind(chosen, kind, GIVES[kind], origin.base)
        except SceneError as error:
            yield ("heat", key), str(error)
    if heat is None:
        return
    if heat.conductivity_bed is not None:
        if heat.effective_gas + heat.effective_solid > 0:
            yield ("heat", "conductivity_bed"), "give either conductivity_bed or effective_gas and effective_solid"
        if heat.conductivity_solid is None:
            yield ("heat", "conductivity_solid"), "missing; conductivity_bed needs it"
    if heat.density == "ideal_gas" and heat.pressure < MIN_PRESSURE:
        yield ("heat", "pressure"), f"absolute; below {MIN_PRESSURE:g} Pa a gas among particles is no continuum"
    if heat.T_reference is not None and heat.density == "constant":
        yield ("heat", "T_reference"), 'belongs to density = "ideal_gas"'


def temperatures_are_possible(heat: Heat | None, initial: t.Initial, boundary: dict[str, t.Boundary]) -> Mistakes:
    """Check that no temperature is beyond what gas and particles bear."""
    places: list[tuple[tuple[str | int, ...], Table]] = [(("initial",), initial)]
    places += [(("initial", "layer", k), layer) for k, layer in enumerate(initial.layer)]
    places += [(("boundary", name), part) for name, part in boundary.items()]
    places += [(("heat",), heat)] if heat is not None else []
    for where, part in places:
        for key in ("T_gas", "T_solid", "T", "T_reference"):
            if (value := getattr(part, key, None)) is not None and value > MAX_TEMPERATURE:
                yield (*where, key), f"above {MAX_TEMPERATURE:g} K gases dissociate and no particle is solid"


def times_are_in_order(time: t.Time, see: See) -> Mistakes:
    """Check that times of averages and steps are in order."""
    if time.average_from is not None and time.average_from >= time.end:
        yield ("time", "average_from"), f"is not before the end; see {see('time.end')}"
    if time.step is not None and time.step > time.end:
        yield ("time", "step"), f"is longer than the run; see {see('time.end')}"
    if time.first > time.longest:
        yield ("time", "first"), f"is longer than the longest step; see {see('time.longest')}"


CHECKS = (
    mesh_has_cells,
    closures_exist,
    friction_of_particles_is_complete,
    filtered_closures_have_their_velocity,
    factors_near_walls_have_what_they_multiply,
    layers_are_in_the_vessel,
    pieces_do_not_overlap,
    particles_fit_the_mesh,
    window_is_in_the_vessel,
    levels_are_in_the_vessel,
    fractions_fit,
    boundaries_are_complete,
    what_enters_can_leave,
    inlets_blow,
    pulses_end_in_an_inlet,
    heat_is_complete,
    closures_of_heat_exist,
    temperatures_are_possible,
    times_are_in_order,
)
