"""What is wrong with a two-fluid scene although every single value is right."""

from __future__ import annotations

from itertools import combinations

from contbed.closures import names, sheet
from contbed.closures.binding import bind
from contbed.errors import SceneError
from contbed.scene import mesh as meshes
from contbed.scene.checking import Mistakes, See
from contbed.scene.names import nearest
from contbed.scene.toml_lines import KeyPath, Origin
from contbed.two_fluid import near_walls
from contbed.two_fluid import scene as t
from contbed.two_fluid.closures import (
    ABSENT,
    FROM_CELLS,
    GIVES,
    KINDS,
    full_name,
    is_filtered_stress,
    takes,
    terminal_velocity,
)
from contbed.two_fluid.conditions import (
    Boundary,
    Initial,
    Inlet,
    Layer,
    Outlet,
    Periodic,
    Wall,
    of_kind,
    places,
)
from contbed.two_fluid.heat.checks import HEAT_CHECKS
from contbed.two_fluid.warnings import WARNINGS as WARNINGS

SAME_THETA = 1e-3  # share by which a granular temperature may be rounded in a scene


def mesh_has_cells(mesh: meshes.Mesh, origin: Origin) -> Mistakes:
    """Check that the mesh is a file that exists or has a number of cells."""
    if isinstance(mesh, meshes.MeshFile):
        if not (origin.base / mesh.file).is_file():
            yield (
                ("mesh", "file"),
                f"no such file; looked for {(origin.base / mesh.file).absolute()}",
            )
    elif mesh.cells is None:
        yield (
            ("mesh", "cells"),
            "missing; a two-fluid model has no layers to grade a mesh by",
        )


def layers_do_not_overlap(initial: Initial) -> Mistakes:
    """Check that no two layers set the same fields in the same place."""
    for (i, first), (k, second) in combinations(enumerate(initial.layer), 2):
        fields = sorted(_given_fields(first) & _given_fields(second))
        if fields and max(first.start, second.start) < min(first.end, second.end):
            text = (
                f"overlaps layer {i + 1}, which sets {', '.join(fields)} there too; "
                "change start and end"
            )
            yield ("initial", "layer", k), text


def _given_fields(layer: Layer) -> set[str]:
    """Return the keys of the fields that a layer sets."""
    found = {f"gas.{key}" for key in layer.gas.model_fields_set}
    for name, solid in layer.solids.items():
        found |= {f"solids.{name}.{key}" for key in solid.model_fields_set}
    return found


def solids_exist(
    solids: dict[str, t.Solid], initial: Initial, boundary: dict[str, Boundary]
) -> Mistakes:
    """Check that the start and the boundaries name solids that the scene has."""
    for where, part in places(initial, boundary):
        for name in getattr(part, "solids", {}):
            if name not in solids:
                yield (
                    (*where, "solids", name),
                    f"no such solid; {nearest(name, list(solids))}",
                )


def gas_has_properties(
    gas: t.Gas, initial: Initial, boundary: dict[str, Boundary], origin: Origin
) -> Mistakes:
    """Check that a gas whose properties vary has a temperature at which they are
    taken.
    """
    try:
        t.fluid_of(gas, initial, boundary, origin.base)
    except SceneError as error:
        yield ("gas",), str(error)


def pieces_do_not_overlap(boundary: dict[str, Boundary]) -> Mistakes:
    """Check that no two pieces of a boundary overlap."""
    pieces = [
        (name, part)
        for name, part in boundary.items()
        if not isinstance(part, Periodic)
        and part.on is not None
        and part.start is not None
        and part.end is not None
    ]
    for (first, one), (second, other) in combinations(pieces, 2):
        assert (
            one.start is not None
            and one.end is not None
            and other.start is not None
            and other.end is not None
        )
        if one.on == other.on and max(one.start, other.start) < min(one.end, other.end):
            yield (
                ("boundary", second, "start"),
                f"overlaps boundary.{first}, also a piece of {one.on!r}",
            )


def window_is_in_order(output: t.Output) -> Mistakes:
    """Check that the window of averages ends above its start."""
    if output.window is not None and output.window.start >= output.window.end:
        yield ("output", "window", "end"), "is not above start"


def levels_are_in_the_vessel(output: t.Output, mesh: meshes.Mesh) -> Mistakes:
    """Check that the heights of lateral profiles lie in the vessel."""
    if isinstance(mesh, meshes.MeshFile):
        return
    for k, level in enumerate(output.levels):
        if not 0.0 <= level < mesh.extents[-1]:
            yield (
                ("output", "levels", k),
                "outside of the vessel, which reaches from 0 to "
                f"{mesh.extents[-1]:.6g} m",
            )


def closures_exist(closures: t.Closures, origin: Origin) -> Mistakes:
    """Check that every closure of the flow exists and can be called."""
    for key, kind in KINDS.items():
        chosen = getattr(closures, key)
        if chosen == ABSENT:
            if kind in ("radial_distribution", "granular_pressure"):
                text = (
                    'cannot be "none"; without collisions: granular_pressure = '
                    '"granular_pressure_dilute"'
                )
                yield ("closures", key), text
            continue
        try:
            bind(chosen, kind, (*GIVES[kind], *FROM_CELLS.get(kind, ())), origin.base)
        except SceneError as error:
            yield ("closures", key), str(error)


def friction_of_particles_is_complete(
    closures: t.Closures, solids: dict[str, t.Solid], see: See, origin: Origin
) -> Mistakes:
    """Check that the friction of particles has its closure, the closure its
    coefficient, and that both fit.
    """
    ((name, solid),) = solids.items()
    chosen, friction = closures.effective_restitution, solid.sliding_friction
    kind, coefficient = "effective_restitution", f"solids.{name}.sliding_friction"
    if chosen == ABSENT:
        if friction is not None:
            text = (
                f"does nothing without closures.{kind}; name one of "
                f"{', '.join(names(kind))}, or leave it out"
            )
            yield ("solids", name, "sliding_friction"), text
        return
    if closures.granular_dissipation == ABSENT:
        known = see("closures.granular_dissipation")
        yield (
            ("closures", kind),
            "is part of the dissipation of granular energy, which is "
            f"switched off; see {known}",
        )
    if friction is None:
        yield (
            ("closures", kind),
            f"needs {coefficient}, Coulomb's coefficient of two particles",
        )
        return
    try:
        value = float(
            bind(chosen, kind, GIVES[kind], origin.base)(
                e=solid.restitution, sliding_friction=friction
            )
        )
    except SceneError:
        return  # closures_exist reports it
    if not 0.0 <= value <= 1.0:
        text = (
            f"gives {value:.4g}, no restitution between 0 and 1; see {see(coefficient)}"
        )
        yield ("closures", kind), f"{text} and {see(f'solids.{name}.restitution')}"


def filtered_closures_have_their_velocity(
    closures: t.Closures,
    two_fluid: t.TwoFluid,
    gas: t.Gas,
    solids: dict[str, t.Solid],
    initial: Initial,
    boundary: dict[str, Boundary],
    see: See,
    origin: Origin,
) -> Mistakes:
    """Check that particles settle, and that the filtered stress has the granular
    temperature that it is given over.
    """
    ((name, solid),) = solids.items()
    if (fluid := t.known_fluid(gas, initial, boundary, origin.base)) is None:
        return
    settling = terminal_velocity(two_fluid.gravity, fluid, solid)
    keys = [
        key
        for key, kind in KINDS.items()
        if kind in FROM_CELLS and takes(getattr(closures, key), kind)
    ]
    if settling <= 0.0:
        for key in keys:
            yield (
                ("closures", key),
                f"needs particles that settle; see {see('two_fluid.gravity')} and the "
                "densities",
            )
        return
    if not is_filtered_stress(closures):
        return
    if two_fluid.granular_temperature != "frozen":
        yield (
            ("two_fluid", "granular_temperature"),
            'must be "frozen": the filtered stress takes its place',
        )
    start = [part.solid.granular_temperature for part in initial.parts]
    if any(
        abs(theta / settling**2 - 1.0) > SAME_THETA
        for theta in start
        if theta is not None
    ):
        text = (
            f"must be {settling**2:.6g} m2/s2, the square of the terminal velocity, "
            "which the filtered stress is over"
        )
        yield ("initial", "solids", name, "granular_temperature"), text


def factors_near_walls_have_what_they_multiply(
    closures: t.Closures,
    two_fluid: t.TwoFluid,
    gas: t.Gas,
    solids: dict[str, t.Solid],
    initial: Initial,
    boundary: dict[str, Boundary],
    origin: Origin,
) -> Mistakes:
    """Check that factors near walls multiply filtered closures, of particles that
    settle.
    """
    (solid,) = solids.values()
    if (fluid := t.known_fluid(gas, initial, boundary, origin.base)) is None:
        return
    for key, of in near_walls.KINDS.items():
        if getattr(closures, key) == ABSENT:
            continue
        name = full_name(getattr(closures, of), KINDS[of])
        absent = getattr(closures, of) == ABSENT
        if absent or (
            name in names(KINDS[of]) and "filter_froude" not in sheet(name).arguments
        ):
            there = ABSENT if absent else name
            text = (
                f"multiplies a filtered {of}, but closures.{of} is {there!r}: leave "
                "it out"
            )
            yield ("closures", key), text
        if terminal_velocity(two_fluid.gravity, fluid, solid) <= 0.0:
            yield (
                ("closures", key),
                "needs particles that settle, under gravity and heavier than the gas",
            )


def fractions_fit(
    initial: Initial,
    boundary: dict[str, Boundary],
    solids: dict[str, t.Solid],
    see: See,
) -> Mistakes:
    """Check that fractions and the onset of friction are below the packing limit,
    and that layers have a height.
    """
    ((solid_name, solid),) = solids.items()
    known, key = (
        see(f"solids.{solid_name}.packing_limit"),
        ("solids", solid_name, "volume_fraction"),
    )
    too_dense, largest = (
        f"denser than the densest packing with its noise; see {known}",
        1.0 + initial.noise,
    )
    if initial.solid.volume_fraction * largest > solid.packing_limit:
        yield ("initial", *key), too_dense
    for k, layer in enumerate(initial.layer):
        if (layer.solid.volume_fraction or 0.0) * largest > solid.packing_limit:
            yield ("initial", "layer", k, *key), too_dense
        if layer.start >= layer.end:
            yield ("initial", "layer", k, "end"), "is not above start"
    for name, part in of_kind(boundary, Inlet).items():
        if part.solid.volume_fraction > solid.packing_limit:
            yield (
                ("boundary", name, *key),
                f"denser than the densest packing; see {known}",
            )
    if solid.friction.start >= solid.packing_limit:
        yield (
            ("solids", solid_name, "friction", "start"),
            f"is not below the densest packing; see {known}",
        )


def boundaries_are_complete(
    boundary: dict[str, Boundary], mesh: meshes.Mesh
) -> Mistakes:
    """Check that each side of the mesh has one condition, and conditions what they
    need.
    """
    sides = (
        ()
        if isinstance(mesh, meshes.MeshFile)
        else tuple(name for pair in mesh.sides for name in pair)
    )
    partners = {part.partner for part in of_kind(boundary, Periodic).values()}
    for name, part in boundary.items():
        where = ("boundary", name)
        whole = getattr(part, "on", None)
        start, end = getattr(part, "start", None), getattr(part, "end", None)
        if whole is not None and (start is None or end is None or start >= end):
            yield where, f"a piece of {whole!r} needs start and end, start below end"
        if sides and (whole or name) not in sides:
            yield (
                where,
                f"the mesh has no boundary {whole or name!r}; it has {', '.join(sides)}",
            )
        if isinstance(part, Periodic) and sides and part.partner not in sides:
            yield (
                (*where, "partner"),
                f"the mesh has no such boundary; it has {', '.join(sides)}",
            )
        if name in partners:
            yield (
                where,
                "is the partner of a periodic boundary and cannot be given twice",
            )
        if isinstance(part, Wall):
            yield from _wall_is_complete(where, part)
        if isinstance(part, Inlet):
            yield from _feed_is_complete(where, part)
    for side in sides:
        if side not in boundary and side not in partners and side != "axis":
            yield (
                ("boundary", side),
                "missing; every side of the mesh needs a condition",
            )


def _wall_is_complete(where: KeyPath, wall: Wall) -> Mistakes:
    """Check that the law of particles at a wall has its coefficients, and that no
    other law has them.
    """
    for name, solid in wall.solids.items():
        here, rough = (*where, "solids", name), solid.wall == "johnson_jackson"
        if rough != (solid.specularity is not None):
            yield (
                (*here, "specularity"),
                "belongs to wall = 'johnson_jackson', which needs it",
            )
        if solid.friction and not rough:
            yield (
                (*here, "friction"),
                "belongs to wall = 'johnson_jackson'; elsewhere particles stick or "
                "slip freely",
            )


def _feed_is_complete(where: KeyPath, inlet: Inlet) -> Mistakes:
    """Check that particles that enter have a fraction and either a flux or a
    velocity.
    """
    for name, solid in inlet.solids.items():
        here, moves = (
            (*where, "solids", name),
            solid.mass_flux is not None or solid.velocity is not None,
        )
        if solid.mass_flux is not None and solid.velocity is not None:
            yield (*here, "velocity"), "give either mass_flux or velocity"
        if (solid.volume_fraction > 0) != moves:
            yield (
                here,
                "particles that enter need volume_fraction and either mass_flux or "
                "velocity",
            )


def what_enters_can_leave(boundary: dict[str, Boundary]) -> Mistakes:
    """Check that there is an outlet where something enters."""
    inlets = list(of_kind(boundary, Inlet))
    if inlets and not of_kind(boundary, Outlet):
        yield (
            ("boundary", inlets[0]),
            "enters but nothing leaves; one boundary has to be of type 'outlet'",
        )


def inlets_blow(boundary: dict[str, Boundary]) -> Mistakes:
    """Check that the velocity of an inlet without particles is given."""
    for name, part in of_kind(boundary, Inlet).items():
        is_known = "velocity" in part.gas.model_fields_set
        if part.solid.volume_fraction == 0.0 and not is_known:
            yield (
                ("boundary", name, "gas", "velocity"),
                "missing; nothing enters (a closed boundary has type = 'wall')",
            )


def pulses_end_in_an_inlet(boundary: dict[str, Boundary]) -> Mistakes:
    """Check that an inlet that ends is a piece of one that does not."""
    for name, part in of_kind(boundary, Inlet).items():
        if part.until is not None:
            whole = boundary.get(part.on or "")
            if not isinstance(whole, Inlet) or whole.until is not None:
                yield (
                    ("boundary", name, "until"),
                    "is for a piece `on` an inlet that has no `until` "
                    "itself; give one of the two",
                )


def times_are_in_order(time: t.Time, see: See) -> Mistakes:
    """Check that times of averages and steps are in order."""
    if time.average_from is not None and time.average_from >= time.end:
        yield ("time", "average_from"), f"is not before the end; see {see('time.end')}"
    if time.step is not None and time.step > time.end:
        yield ("time", "step"), f"is longer than the run; see {see('time.end')}"
    if time.first > time.longest:
        yield (
            ("time", "first"),
            f"is longer than the longest step; see {see('time.longest')}",
        )


CHECKS = (
    *HEAT_CHECKS,
    mesh_has_cells,
    solids_exist,
    gas_has_properties,
    closures_exist,
    friction_of_particles_is_complete,
    filtered_closures_have_their_velocity,
    factors_near_walls_have_what_they_multiply,
    layers_do_not_overlap,
    pieces_do_not_overlap,
    window_is_in_order,
    levels_are_in_the_vessel,
    fractions_fit,
    boundaries_are_complete,
    what_enters_can_leave,
    inlets_blow,
    pulses_end_in_an_inlet,
    times_are_in_order,
)
