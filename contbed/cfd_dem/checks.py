"""What is wrong with a scene of particles in a gas although every single value is
right.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from math import hypot, pi

from contbed.cfd_dem import scene as g
from contbed.cfd_dem.closures import GIVES, bound_tube
from contbed.closures.binding import bind
from contbed.dem.particle_files import read_particles, tells_radii
from contbed.dem.particles import Material
from contbed.dem.scene import SOLID_SHARE
from contbed.dem.softness import DENSER, too_soft
from contbed.errors import SceneError
from contbed.scene import moments
from contbed.scene.checking import Mistakes, See
from contbed.scene.gas import GasCantera, GasConstant, GasCoolProp
from contbed.scene.solids import the_only
from contbed.scene.toml_lines import BARE_KEY, Origin

ROUNDING = 1e-9  # relative, of lengths that are meant to be equal
Solids = Mapping[str, g.GasSolid]


def one_source(
    particles: g.GasParticles, solids: Solids, origin: Origin, see: See
) -> Mistakes:
    """Require either a count or a file of particles, with all that it needs."""
    if (particles.count is None) == (particles.file is None):
        yield ("particles",), "give either count, to settle a bed, or file"
    name, solid = the_only(solids)
    key = ("solids", name, "diameter")
    if particles.file is None:
        if solid.diameter is None:
            yield key, "missing; settled spheres need it"
        elif solid.diameter > min(particles.width):
            diameter = see(f"solids.{name}.diameter")
            yield ("particles", "width"), f"narrower than a sphere; see {diameter}"
        return
    path = origin.base / particles.file
    if "\0" in particles.file or not path.is_file():
        text = f"no such file; looked for {path.absolute()}"
        yield ("particles", "file"), text
    elif solid.diameter is None and not tells_radii(path):
        yield key, f"missing; {particles.file} has no radii"


def cells_fit_into_the_box(
    particles: g.GasParticles, solids: Solids, origin: Origin, see: See
) -> Mistakes:
    """Require at least two cells of the gas above each other."""
    if particles.file is not None and not _is_file(particles.file, origin):
        return
    high = _cell(particles, solids, origin)[1]
    if high > 0.0 and round(particles.height / high) < 2:
        yield (
            ("particles", "cell", 1),
            f"cells of {high:.3g} m leave {max(1, round(particles.height / high))} in "
            f"the height of {particles.height:.3g} m, at least 2 are needed; cells "
            f"count in particle diameters; see {see('particles.height')}",
        )


def _is_file(name: str, origin: Origin) -> bool:
    """Return whether a file of the scene exists."""
    return "\0" not in name and (origin.base / name).is_file()


def heat_has_a_closure(
    closures: g.Closures, particles: g.GasParticles, heat: g.GasHeat | None, see: See
) -> Mistakes:
    """Require a Nusselt number where the scene asks for heat that is exchanged."""
    if closures.nusselt is not None:
        return
    for there, key in (
        (heat, "heat"),
        (particles.closure, "particles.closure"),
        (particles.tubes, "particles.tubes"),
    ):
        if there is not None and there != {}:
            text = f"missing; {see(key)} needs it. `contbed closures --for closures.nusselt` lists some"
            yield ("closures", "nusselt"), text
            return


def properties_are_complete(
    gas: GasConstant | GasCantera | GasCoolProp, solids: Solids, closures: g.Closures
) -> Mistakes:
    """Require conductivities, and the heat capacity of constant properties, where heat
    is exchanged, and fractions that sum to one.
    """
    name, solid = the_only(solids)
    if closures.nusselt is not None and not solid.conductivity:
        key = ("solids", name, "conductivity")
        yield key, "missing or 0; heat transfer coefficients need it"
    if isinstance(gas, GasConstant) and closures.nusselt is not None:
        for name in ("heat_capacity", "conductivity"):
            if not getattr(gas, name):
                yield ("gas", name), "missing or 0; heat transfer coefficients need it"
    elif isinstance(gas, GasCantera):
        from contbed.materials.composition import require_sum

        try:
            require_sum(gas.composition)
        except SceneError as error:
            yield ("gas", "composition"), str(error)


def closures_exist(closures: g.Closures, origin: Origin) -> Mistakes:
    """Require closures that exist and whose arguments the gas around a particle
    gives.
    """
    for kind, gives in GIVES.items():
        if (spec := getattr(closures, kind)) is None:
            continue
        try:
            bind(spec, kind, gives, origin.base)
        except SceneError as error:
            yield ("closures", kind), str(error)


def jet_is_in_the_floor(
    boundary: g.Boundary, particles: g.GasParticles, see: See
) -> Mistakes:
    """Require one flow of the jet, and that its slot lies in the floor of the bed."""
    jet = boundary.jet
    if jet is not None and (jet.gas.velocity is None) == (jet.gas.mass_flux is None):
        yield ("boundary", "jet", "gas"), "give either velocity or mass_flux"
    if jet is not None and not 0.0 <= jet.start < jet.end <= particles.width[0]:
        width = see("particles.width")
        text = f"start to end is not a piece of the floor from 0 on; see {width}"
        yield ("boundary", "jet"), text


def jet_has_its_own_temperature(
    boundary: g.Boundary, heat: g.GasHeat | None, see: See
) -> Mistakes:
    """Refuse a jet of another temperature where no energy equation is solved."""
    jet, T = boundary.jet, boundary.bottom.gas.temperature
    if jet is not None and heat is None and jet.gas.temperature not in (None, T):
        main = see("boundary.bottom.gas.temperature")
        yield (
            ("boundary", "jet", "gas", "temperature"),
            f"differs from that of the gas, {main}, without a [heat] table",
        )


def particles_have_a_temperature(
    heat: g.GasHeat | None, initial: g.Initial, solids: Solids, see: See
) -> Mistakes:
    """Require the temperature of the particles at the start where it is solved for."""
    name, _ = the_only(solids)
    for other in initial.solids:
        if other != name:
            text = f"no such solid phase; there is {see(f'solids.{name}')}"
            yield ("initial", "solids", other), text
    given = name in initial.solids
    key = ("initial", "solids", name, "temperature")
    if heat is not None and not given:
        yield key, f"missing; {see('heat')} needs it"
    elif heat is None and given:
        yield key, "has no use without a [heat] table"


def times_are_in_order(time: g.GasTime, see: See) -> Mistakes:
    """Require averages that begin before the end of the run and last for a sample."""
    end = see("time.end")
    if time.average_from >= time.end:
        yield ("time", "average_from"), f"is not before the end; see {end}"
    if time.sample > time.end - time.average_from:
        text = f"longer than the averages, from average_from to end; see {end}"
        yield ("time", "sample"), text


def closure_is_of_a_fixed_bed(particles: g.GasParticles, see: See) -> Mistakes:
    """Refuse to fit a Nusselt number to particles that move."""
    if particles.closure is not None and not particles.fixed:
        fixed = see("particles.fixed")
        text = f"a Nusselt number is fitted to a bed at rest; set {fixed} = true"
        yield ("particles", "closure"), text


def tubes_are_in_the_box(
    particles: g.GasParticles, solids: Solids, heat: g.GasHeat | None, see: See
) -> Mistakes:
    """Require tubes that lie in the box side by side, with known closures; those
    with a temperature need [heat].
    """
    tubes, (wide, _), high = particles.tubes, particles.width, particles.height
    for name, tube in tubes.items():
        key = ("particles", "tubes", name)
        radius, (x, z) = 0.5 * tube.diameter, tube.centre
        if not BARE_KEY.fullmatch(name):
            yield key, "names a file; letters, digits, - and _ may stand in it"
        if not (radius <= x <= wide - radius and radius <= z <= high - radius):
            yield (
                (*key, "centre"),
                f"the tube of {tube.diameter:.4g} m reaches out of the box of "
                f"{wide:g} m by {high:g} m; see {see('particles.width')} and "
                f"{see('particles.height')}",
            )
        if tube.temperature is not None and heat is None:
            text = "needs a [heat] table; without one a tube has coefficients alone"
            yield (*key, "temperature"), text
        try:
            bound_tube(tube)
        except SceneError as error:
            yield (*key, "nusselt"), str(error)
            return
    for (first, one), (second, other) in combinations(tubes.items(), 2):
        apart = hypot(*(a - b for a, b in zip(one.centre, other.centre, strict=True)))
        if apart < 0.5 * (one.diameter + other.diameter):
            where = see(f"particles.tubes.{first}.centre")
            key = ("particles", "tubes", second)
            yield (*key, "centre"), f"overlaps {first}; see {where}"
            return
    solid = the_only(solids)[1]
    if tubes and particles.file is None and solid.radius is not None:
        from contbed.cfd_dem.plan import grid_of, tubes_of

        try:
            grid_of(particles, solid, tubes=tubes_of(particles))
        except SceneError as error:
            yield ("particles", "cell"), str(error)


def probes_are_outside_of_tubes(
    output: g.GasOutput, particles: g.GasParticles, see: See
) -> Mistakes:
    """Require that probes lie in the gas."""
    for name, (x, _, z) in output.probes.items():
        for tube, table in particles.tubes.items():
            apart = hypot(x - table.centre[0], z - table.centre[1])
            if apart < 0.5 * table.diameter:
                centre = see(f"particles.tubes.{tube}.centre")
                text = f"lies in the tube {tube}; see {centre}"
                yield ("output", "probes", name), text


def file_can_be_used(
    particles: g.GasParticles, solids: Solids, origin: Origin
) -> Mistakes:
    """Read the file and set up its particles as for a run, so that both say the
    same.
    """
    if particles.file is None or particles.count is not None:
        return
    solid = the_only(solids)[1]
    if not _is_file(particles.file, origin):
        return
    if solid.radius is None and not tells_radii(origin.base / particles.file):
        return
    from contbed.cfd_dem.plan import (
        at_start,
        grid_of,
        require_room,
        simulation_of,
        tubes_of,
    )

    tubes = tubes_of(particles)
    found, _ = at_start(particles, solid, tubes, origin.base)
    require_room(particles, found, origin)
    try:
        if tubes:
            grid_of(particles, solid, found, tubes)
        simulation_of(particles, solid, found, tubes=tubes)
    except SceneError as error:
        yield ("particles", "file"), str(error)


def probes_are_in_the_box(
    output: g.GasOutput, particles: g.GasParticles, see: See
) -> Mistakes:
    """Require that probes lie in the box."""
    room = (*particles.width, particles.height)
    for name, point in output.probes.items():
        inside = [0.0 <= x <= length for x, length in zip(point, room, strict=True)]
        if not all(inside):
            yield (
                ("output", "probes", name),
                f"is outside of the box from 0 to {room[0]:g}, {room[1]:g} and "
                f"{room[2]:g} m; see {see('particles.width')} and "
                f"{see('particles.height')}",
            )


def levels_are_in_the_box(
    output: g.GasOutput, particles: g.GasParticles, see: See
) -> Mistakes:
    """Require that heights for averages across the bed lie in the box."""
    high = particles.height
    for k, height in enumerate(output.levels):
        if not 0.0 <= height <= high:
            where = see("particles.height")
            text = f"is outside of the box from 0 to {high:g} m; see {where}"
            yield ("output", "levels", k), text


def poisson_ratio_is_of_a_solid(solids: Solids) -> Mistakes:
    """Look for a Poisson's ratio that only special foams have."""
    name, solid = the_only(solids)
    if solid.poisson_ratio < 0.0:
        yield (
            ("solids", name, "poisson_ratio"),
            "is negative: only re-entrant foams have this; glass, metals, rock and "
            "polymers have 0.1 to 0.5",
        )


def cells_lie_inside_of_the_bed(
    particles: g.GasParticles, solids: Solids, origin: Origin
) -> Mistakes:
    """Look for cells of the gas wider than the bed, which become one cell."""
    cell = _cell(particles, solids, origin)[0]
    for axis, width in zip("xy", particles.width, strict=True):
        if cell > width * (1.0 + ROUNDING):
            yield (
                ("particles", "cell", 0),
                f"{cell:.3g} m in {axis}, the bed is {width:.3g} m wide: one cell "
                "across; cells count in particle diameters",
            )


def cells_are_larger_than_particles(particles: g.GasParticles) -> Mistakes:
    """Look for cells of the gas in which a particle counts as a whole though it is
    larger than they are.
    """
    for axis, cell in enumerate(particles.cell):
        if cell < 1.0 - ROUNDING:
            yield (
                ("particles", "cell", axis),
                f"{'width' if axis == 0 else 'height'} of {cell:g} particle diameters: "
                "drag and porosity are averages over a cell, which needs several "
                "particles; 3 and 1 are usual",
            )


def times_are_within_the_run(time: g.GasTime, boundary: g.Boundary) -> Mistakes:
    """Look for what is written or switched after the end of the run."""
    yield from moments.of_output(time, time.sample)
    if boundary.jet is not None:
        yield from moments.of_inlet(("boundary", "jet"), boundary.jet.until, time.end)


def contacts_have_a_stiffness(
    particles: g.GasParticles, solids: Solids, closures: g.Closures
) -> Mistakes:
    """Look for contacts that conduct as those of a soft simulation."""
    name, solid = the_only(solids)
    conducts = solid.conductivity and closures.nusselt is not None
    if not conducts or solid.youngs_modulus is not None:
        return
    yield (
        ("solids", name, "youngs_modulus"),
        f"missing; contacts conduct as those of the simulation at "
        f"{particles.modulus:g} Pa, up to 30 times more than real ones. Give Young's "
        "modulus of the material (glass 6.9e10 Pa), or a material of the library",
    )


def spheres_bear_the_bed(particles: g.GasParticles, solids: Solids) -> Mistakes:
    """Look for spheres so soft that the bed packs denser under its weight, and lets
    less gas through.
    """
    solid, count = the_only(solids)[1], particles.count
    radius = solid.radius
    if particles.fixed or not particles.gravity or radius is None or count is None:
        return
    area = particles.width[0] * particles.width[1]
    height = count * 4.0 / 3.0 * pi * radius**3 / (SOLID_SHARE * area)
    if found := too_soft(height, radius, Material.of(solid, particles.modulus)):
        denser, enough = found
        yield (
            ("particles", "modulus"),
            f"so soft that a bed about {height:.2g} m high packs {denser:.1%} denser "
            "under its weight: less gas passes through particles at rest and more "
            f"through jets and bubbles; {enough:.2g} Pa keep that to {DENSER:.0%}",
        )


def _cell(
    particles: g.GasParticles, solids: Solids, origin: Origin
) -> tuple[float, float]:
    """Return width and height of the cells of the gas [m] that the scene asks for; 0
    where no radius is known.
    """
    radius = the_only(solids)[1].radius
    if radius is None and particles.file is not None:
        path = origin.base / particles.file
        if tells_radii(path):
            radius = float(read_particles(path).radius.max())
    wide, high = (2.0 * (radius or 0.0) * size for size in particles.cell)
    return wide, high


CHECKS = (
    one_source,
    cells_fit_into_the_box,
    heat_has_a_closure,
    properties_are_complete,
    closures_exist,
    jet_is_in_the_floor,
    jet_has_its_own_temperature,
    particles_have_a_temperature,
    times_are_in_order,
    closure_is_of_a_fixed_bed,
    file_can_be_used,
    probes_are_in_the_box,
    levels_are_in_the_box,
    tubes_are_in_the_box,
    probes_are_outside_of_tubes,
)
WARNINGS = (
    poisson_ratio_is_of_a_solid,
    cells_lie_inside_of_the_bed,
    cells_are_larger_than_particles,
    spheres_bear_the_bed,
    times_are_within_the_run,
    contacts_have_a_stiffness,
)
