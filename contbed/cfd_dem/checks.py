"""What is wrong with a scene of particles in a gas although every single value is right."""

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
from contbed.scene.checking import Mistakes, See
from contbed.scene.tables import FluidCantera, FluidConstant
from contbed.scene.toml_lines import BARE_KEY, Origin

ROUNDING = 1e-9  # relative, of lengths that are meant to be equal


def one_source(particles: g.GasParticles, origin: Origin, see: See) -> Mistakes:
    """Require either a count or a file of particles, with all that it needs."""
    if (particles.count is None) == (particles.file is None):
        yield ("particles",), "give either count, to settle a bed, or file"
    if particles.file is None:
        if particles.radius is None:
            yield ("particles", "radius"), "missing; settled spheres need it"
        elif 2.0 * particles.radius > min(particles.width):
            yield ("particles", "width"), f"narrower than a sphere; see {see('particles.radius')}"
        return
    path = origin.base / particles.file
    if "\0" in particles.file or not path.is_file():
        yield ("particles", "file"), f"no such file; looked for {path.absolute()}"
    elif particles.radius is None and not tells_radii(path):
        yield ("particles", "radius"), f"missing; {particles.file} has none"


def cells_fit_into_the_box(particles: g.GasParticles, gas: g.GasFlow, origin: Origin, see: See) -> Mistakes:
    """Require at least two cells of the gas above each other."""
    if particles.file is not None and ("\0" in particles.file or not (origin.base / particles.file).is_file()):
        return
    high = _cell(particles, gas, origin)[1]
    if high > 0.0 and round(gas.height / high) < 2:
        yield (
            ("gas", "cell", 1),
            f"cells of {high:.3g} m leave {max(1, round(gas.height / high))} in the height of {gas.height:.3g} m, at "
            f"least 2 are needed; cells count in particle diameters; see {see('gas.height')}",
        )


def fluid_is_complete(fluid: FluidConstant | FluidCantera) -> Mistakes:
    """Require heat capacity and conductivity of constant properties, and fractions of a mixture that sum to one."""
    if isinstance(fluid, FluidConstant):
        for name in ("heat_capacity", "conductivity"):
            if not getattr(fluid, name):
                yield ("fluid", name), "missing or 0; heat transfer coefficients need it"
    else:
        from contbed.materials.composition import require_sum

        try:
            require_sum(fluid.composition)
        except SceneError as error:
            yield ("fluid", "composition"), str(error)


def closures_exist(gas: g.GasFlow, origin: Origin) -> Mistakes:
    """Require closures that exist and whose arguments the gas around a particle gives."""
    for kind, gives in GIVES.items():
        try:
            bind(getattr(gas, kind), kind, gives, origin.base)
        except SceneError as error:
            yield ("gas", kind), str(error)


def jet_is_in_the_floor(gas: g.GasFlow, particles: g.GasParticles, see: See) -> Mistakes:
    """Require that the slot of the jet lies in the floor of the bed."""
    if gas.jet is None:
        return
    low, high = gas.jet.slot
    if not 0.0 <= low < high <= particles.width[0]:
        yield ("gas", "jet", "slot"), f"is not a piece of the floor from 0 on; see {see('particles.width')}"


def jet_is_told_apart(gas: g.GasFlow, heat: g.GasHeat | None, see: See) -> Mistakes:
    """Refuse a jet of another temperature where no energy equation is solved."""
    if gas.jet is not None and heat is None and gas.jet.T != gas.T:
        yield ("gas", "jet", "T"), f"differs from the gas, {see('gas.T')}, without a [heat] table"


def times_are_in_order(time: g.GasTime, see: See) -> Mistakes:
    """Require at least one sample between the start of the averages and the end of the run."""
    if time.average_from >= time.end:
        yield ("time", "average_from"), f"is not before the end; see {see('time.end')}"
    if time.sample > time.end - time.average_from:
        yield ("time", "sample"), f"no sample between average_from and end; see {see('time.end')}"


def closure_is_of_a_fixed_bed(closure: g.NusseltClosure | None, particles: g.GasParticles, see: See) -> Mistakes:
    """Refuse to fit a Nusselt number to particles that move."""
    if closure is not None and not particles.fixed:
        yield ("closure",), f"a Nusselt number is fitted to a bed at rest; set {see('particles.fixed')} = true"


def tubes_are_in_the_box(
    tubes: Mapping[str, g.GasTube], particles: g.GasParticles, gas: g.GasFlow, heat: g.GasHeat | None, see: See
) -> Mistakes:
    """Require tubes that lie in the box side by side, with known closures, and with [heat] where they have a T."""
    for name, tube in tubes.items():
        radius, (x, z) = 0.5 * tube.diameter, tube.centre
        if not BARE_KEY.fullmatch(name):
            yield ("tubes", name), "names a file; letters, digits, - and _ may stand in it"
        if not (radius <= x <= particles.width[0] - radius and radius <= z <= gas.height - radius):
            yield (
                ("tubes", name, "centre"),
                f"the tube of {tube.diameter:.4g} m reaches out of the box of {particles.width[0]:g} m by "
                f"{gas.height:g} m; see {see('particles.width')} and {see('gas.height')}",
            )
        if tube.T is not None and heat is None:
            yield ("tubes", name, "T"), "needs a [heat] table; without one a tube has coefficients alone"
        try:
            bound_tube(tube)
        except SceneError as error:
            yield ("tubes", name, "nusselt"), str(error)
            return
    for (first, one), (second, other) in combinations(tubes.items(), 2):
        if hypot(*(a - b for a, b in zip(one.centre, other.centre, strict=True))) < 0.5 * (
            one.diameter + other.diameter
        ):
            yield ("tubes", second, "centre"), f"overlaps {first}; see {see(f'tubes.{first}.centre')}"
            return
    if tubes and particles.file is None and particles.radius is not None:
        from contbed.cfd_dem.plan import grid_of, tubes_of

        try:
            grid_of(particles, gas, tubes=tubes_of(tubes, particles))
        except SceneError as error:
            yield ("gas", "cell"), str(error)


def probes_are_outside_of_tubes(output: g.GasOutput, tubes: Mapping[str, g.GasTube], see: See) -> Mistakes:
    """Require that probes lie in the gas."""
    for name, (x, _, z) in output.probes.items():
        for tube, table in tubes.items():
            if hypot(x - table.centre[0], z - table.centre[1]) < 0.5 * table.diameter:
                yield ("output", "probes", name), f"lies in the tube {tube}; see {see(f'tubes.{tube}.centre')}"


def file_can_be_used(
    particles: g.GasParticles, gas: g.GasFlow, tubes: Mapping[str, g.GasTube], origin: Origin
) -> Mistakes:
    """Read the file and set up its particles as for a run, so that both say the same."""
    if particles.file is None or particles.count is not None or "\0" in particles.file:
        return
    path = origin.base / particles.file
    if not path.is_file() or (particles.radius is None and not tells_radii(path)):
        return
    from contbed.cfd_dem.plan import at_start, grid_of, require_room, simulation_of, tubes_of

    there = tubes_of(tubes, particles)
    found, _ = at_start(particles, there, origin.base)
    require_room(particles, gas, found, origin)
    try:
        if there:
            grid_of(particles, gas, found, there)
        simulation_of(particles, gas, found, tubes=there)
    except SceneError as error:
        yield ("particles", "file"), str(error)


def probes_are_in_the_box(output: g.GasOutput, particles: g.GasParticles, gas: g.GasFlow, see: See) -> Mistakes:
    """Require that probes lie in the box."""
    room = (*particles.width, gas.height)
    for name, point in output.probes.items():
        if not all(0.0 <= x <= length for x, length in zip(point, room, strict=True)):
            yield (
                ("output", "probes", name),
                f"is outside of the box from 0 to {room[0]:g}, {room[1]:g} and {room[2]:g} m; "
                f"see {see('particles.width')} and {see('gas.height')}",
            )


def levels_are_in_the_box(output: g.GasOutput, gas: g.GasFlow, see: See) -> Mistakes:
    """Require that heights for averages across the bed lie in the box."""
    for k, height in enumerate(output.levels):
        if not 0.0 <= height <= gas.height:
            yield ("output", "levels", k), f"is outside of the box from 0 to {gas.height:g} m; see {see('gas.height')}"


def poisson_ratio_is_of_a_solid(particles: g.GasParticles) -> Mistakes:
    """Look for a Poisson's ratio that only special foams have."""
    if particles.poisson_ratio < 0.0:
        yield (
            ("particles", "poisson_ratio"),
            "is negative: only re-entrant foams have this; glass, metals, rock and polymers have 0.1 to 0.5",
        )


def cells_lie_inside_of_the_bed(particles: g.GasParticles, gas: g.GasFlow, origin: Origin) -> Mistakes:
    """Look for cells of the gas wider than the bed, which become one cell."""
    for axis, (width, cell) in enumerate(zip(particles.width, (_cell(particles, gas, origin)[0],) * 2, strict=True)):
        if cell > width * (1.0 + ROUNDING):
            yield (
                ("gas", "cell", 0),
                f"{cell:.3g} m in {'xy'[axis]}, the bed is {width:.3g} m wide: one cell across; "
                "cells count in particle diameters",
            )


def cells_are_larger_than_particles(gas: g.GasFlow) -> Mistakes:
    """Look for cells of the gas in which a particle counts as a whole though it is larger than they are."""
    for axis, cell in enumerate(gas.cell):
        if cell < 1.0 - ROUNDING:
            yield (
                ("gas", "cell", axis),
                f"{'width' if axis == 0 else 'height'} of {cell:g} particle diameters: drag and porosity are averages "
                "over a cell, which needs several particles; 3 and 1 are usual",
            )


def spheres_bear_the_bed(particles: g.GasParticles, gas: g.GasFlow) -> Mistakes:
    """Look for spheres so soft that the bed packs denser under its weight, and lets less gas through."""
    radius, count = particles.radius, particles.count
    if particles.fixed or not gas.gravity or radius is None or count is None:
        return
    height = count * 4.0 / 3.0 * pi * radius**3 / (SOLID_SHARE * particles.width[0] * particles.width[1])
    material = Material(particles.density, particles.modulus, particles.poisson_ratio)
    if found := too_soft(height, radius, material):
        denser, enough = found
        yield (
            ("particles", "modulus"),
            f"so soft that a bed about {height:.2g} m high packs {denser:.1%} denser under its weight: less gas "
            "passes through particles at rest and more through jets and bubbles; "
            f"{enough:.2g} Pa keep that to {DENSER:.0%}",
        )


def _cell(particles: g.GasParticles, gas: g.GasFlow, origin: Origin) -> tuple[float, float]:
    """Width and height of the cells of the gas [m] that the scene asks for; 0 where no radius is known."""
    radius = particles.radius
    if radius is None and particles.file is not None and tells_radii(origin.base / particles.file):
        radius = float(read_particles(origin.base / particles.file).radius.max())
    wide, high = (2.0 * (radius or 0.0) * size for size in gas.cell)
    return wide, high


CHECKS = (
    one_source,
    cells_fit_into_the_box,
    fluid_is_complete,
    closures_exist,
    jet_is_in_the_floor,
    jet_is_told_apart,
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
)
