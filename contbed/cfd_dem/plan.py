"""What a run of particles in a gas builds: the particles at the start, their box and
the grid of the gas.

A bed that has to settle does so in the run.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil
from pathlib import Path
from typing import Any, Literal

import numpy as np

from contbed.cfd_dem.closures import bound_tube
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.scene import GasParticles, GasScene, GasSolid, GasTube
from contbed.cfd_dem.tubes import BedTube, beside, blocked
from contbed.dem.contact import hertz_impact
from contbed.dem.packing import SETTLED_OVERLAP, pack
from contbed.dem.particle_files import read_particles, wrapped
from contbed.dem.particles import Material, Particles
from contbed.dem.plan import particles_by
from contbed.dem.simulation import LARGEST_OVERLAP, Simulation
from contbed.dem.softness import GRAVITY
from contbed.dem.walls import INFINITE, Domain, box
from contbed.errors import SceneError
from contbed.plan_text import plan_text
from contbed.scene.toml_lines import Origin
from contbed.solvers.memory import MemoryPerUnknown

# of the radius; fluidized beds need new lists a third as often as at the 0.1 of
# packings, 30 % less time
SKIN = 0.4
# m/s, impacts at this speed are resolved by the time step of the particles
IMPACT_SPEED = 0.3
# bytes for each unknown; six of a particle, with its neighbours: 300 in a bed of 175
# 800
MEMORY = MemoryPerUnknown(400.0)
# of that step, where a stray particle is too fast for it: four times the speed, and the
# work
MOST_HALVINGS = 2
# m/s, at which particles of a bubbling bed may meet when their file is written
SPEED_OF_FILES = 1.0


@dataclass(frozen=True)
class GasPlan:
    """The particles at the start, None before they have settled, their box, tubes in
    it and the grid of the gas.
    """

    scene: GasScene
    particles: Particles | None
    grid: Grid
    built: tuple[tuple[str, str], ...]
    skipped: tuple[tuple[str, str], ...]
    mesh: None = None
    policy: MemoryPerUnknown = MEMORY
    steps: bool = True
    tubes: tuple[BedTube, ...] = ()
    engine: Literal["contbed", "cuda"] = "contbed"

    @property
    def number(self) -> int:
        """Number of particles."""
        if self.particles is not None:
            return len(self.particles)
        assert self.scene.particles.count is not None
        return self.scene.particles.count

    def unknowns(self) -> dict[str, int]:
        """Count the unknowns: coordinates of particles, velocities and pressures of
        the gas, temperatures.
        """
        moving = 0 if self.scene.particles.fixed else 6 * self.number
        heat = self.number + self.grid.cells if self.scene.heat is not None else 0
        return {
            "particles": moving,
            "gas": int(self.grid.active.sum()) + self.grid.cells,
            "heat": heat,
        }

    def on_gpu(self) -> GasPlan:
        """Return the plan of a run whose particles move on a GPU; the gas is
        computed on this machine's cores.
        """
        return replace(self, engine="cuda", built=particles_by(self.built, "on a GPU"))

    def __str__(self) -> str:
        return plan_text(self)


def plan(scene: GasScene) -> GasPlan:
    """Read the particles of a file and lay the grid.

    Raises
    ------
    SceneError : the file of particles cannot be used, or particles are outside of the
        box
    """
    table, particles, inside = scene.particles, None, 0
    tubes = tubes_of(table)
    if table.file is not None:
        particles, inside = at_start(table, scene.solid, tubes, scene.origin.base)
        require_room(table, particles, scene.origin)
    grid = grid_of(table, scene.solid, particles, tubes)
    number = (
        f"{table.count}, settled from a random start"
        if particles is None
        else f"{len(particles)}"
    )
    if tubes and particles is None:
        number += " before those in tubes are taken out"
    elif inside:
        number += f", {inside} in tubes are left out"
    built = [
        ("particles", f"{number}, {'fixed' if table.fixed else 'moving'}"),
        ("gas", " x ".join(str(n) for n in grid.count) + " cells"),
        ("steps", f"{ceil(scene.time.end / scene.time.step)} of the gas"),
    ]
    skipped: list[tuple[str, str]] = []
    for there, what, how, why in (
        (
            scene.heat is not None,
            "energy",
            "gas and particles",
            "no [heat] table: one temperature",
        ),
        (
            scene.solid.emissivity > 0.0,
            "radiation",
            "to the neighbours",
            "emissivity of the particles is 0",
        ),
        (
            table.closure is not None,
            "closure file",
            "power of Re",
            "no [particles.closure] table",
        ),
        (bool(tubes), "tubes", ", ".join(table.tubes), "no [particles.tubes] table"),
    ):
        (built if there else skipped).append((what, how if there else why))
    return GasPlan(scene, particles, grid, tuple(built), tuple(skipped), tubes=tubes)


def settled(
    plan: GasPlan, quiet: bool, start: Mapping[str, Any] | None = None
) -> GasPlan:
    """Return the plan with its particles, which settle if no file holds them.

    Parameters
    ----------
    plan : from `plan`
    quiet : no progress bar
    start : arrays of a checkpoint, whose particles need not settle again

    Raises
    ------
    SceneError : the bed is higher than the box
    ConvergenceError : the bed does not settle
    """
    if plan.particles is not None:
        return plan
    table, solid = plan.scene.particles, plan.scene.solid
    if start is not None:
        assert solid.radius is not None
        return replace(
            plan, particles=Particles(start["particles_position"], solid.radius)
        )
    particles = _settle(table, solid, quiet, plan.engine)
    require_room(table, particles, plan.scene.origin)
    return replace(
        plan, particles=_outside_of_tubes(particles, plan.tubes, LARGEST_OVERLAP)[0]
    )


def tubes_of(table: GasParticles) -> tuple[BedTube, ...]:
    """Build the tubes of a scene, which cross the whole depth of the bed."""
    depth = table.width[1]
    return tuple(_tube(name, tube, depth) for name, tube in table.tubes.items())


def _tube(name: str, table: GasTube, depth: float) -> BedTube:
    """Build one tube."""
    return BedTube(
        name,
        *table.centre,
        0.5 * table.diameter,
        depth,
        bound_tube(table),
        table.temperature,
    )


def _outside_of_tubes(
    particles: Particles, tubes: Sequence[BedTube], overlap: float
) -> tuple[Particles, int]:
    """Leave out particles that overlap a tube by more than `overlap` radii; return
    the others and their number.
    """
    x, kept = particles.position, np.ones(len(particles), bool)
    for tube in tubes:
        kept &= tube.distance(x) > tube.radius + (1.0 - overlap) * particles.radius
    if kept.all():
        return particles, 0
    chosen = (
        getattr(particles, name)[kept]
        for name in ("position", "radius", "material", "velocity", "spin")
    )
    return Particles(*chosen), int((~kept).sum())


def simulation_of(
    table: GasParticles,
    solid: GasSolid,
    particles: Particles,
    engine: Literal["contbed", "cuda"] = "contbed",
    tubes: Sequence[BedTube] = (),
) -> Simulation:
    """Set up the simulation of the particles in their box.

    Raises
    ------
    SceneError : they overlap each other or a wall
    EngineError : there is no GPU for them
    """
    domain = _domain(table)
    return Simulation(
        particles,
        [Material.of(solid, table.modulus)],
        [*box(domain), *(tube.wall for tube in tubes)],
        domain,
        impact_speed=IMPACT_SPEED,
        skin=SKIN * float(particles.radius.min()),
        gravity=(0.0, 0.0, -GRAVITY if table.gravity else 0.0),
        largest_overlap=SETTLED_OVERLAP
        if table.file is None
        else _largest_overlap(table, solid, particles),
        most_halvings=MOST_HALVINGS,
        engine=engine,
    )


def _largest_overlap(
    table: GasParticles, solid: GasSolid, particles: Particles
) -> float:
    """Return the overlap over the smaller radius up to which particles of a file are
    accepted at their stiffness.

    It is that of an impact at `SPEED_OF_FILES`: soft particles of a bed that runs or
    has settled overlap as deeply, and larger overlaps would throw them apart faster.
    """
    radius, material = float(particles.radius.min()), Material.of(solid, table.modulus)
    mass = 4.0 / 3.0 * np.pi * radius**3 * material.density
    deep = (
        hertz_impact(
            mass / 2.0, radius / 2.0, material.contact_modulus, SPEED_OF_FILES
        )[1]
        / radius
    )
    return float(np.clip(deep, LARGEST_OVERLAP, SETTLED_OVERLAP))


def _domain(table: GasParticles) -> Domain:
    return Domain(
        (0.0, 0.0, 0.0),
        (*table.width, INFINITE),
        (table.periodic, table.periodic, False),
    )


def grid_of(
    table: GasParticles,
    solid: GasSolid,
    particles: Particles | None = None,
    tubes: Sequence[BedTube] = (),
) -> Grid:
    """Lay cells of about the asked size that fill the box; those in tubes are blocked.

    Raises
    ------
    SceneError : cells are too coarse for a tube
    """
    radius = solid.radius
    smallest, largest = (
        (radius, radius)
        if particles is None
        else (particles.radius.min(), particles.radius.max())
    )
    assert smallest is not None and largest is not None
    diameter = 2.0 * float(largest)
    wide, high = (scale * diameter for scale in table.cell)
    lengths = (*table.width, table.height)
    nx, ny, nz = (
        max(1, round(length / size))
        for length, size in zip(lengths, (wide, wide, high), strict=True)
    )
    size, count = np.array(lengths) / (nx, ny, nz), (nx, ny, nz)
    shut = blocked(size, count, tubes, 2.0 * float(smallest))
    grid = Grid(np.zeros(3), size, count, (table.periodic,) * 2, shut)
    for tube in tubes:
        beside(grid, tube)
    return grid


def _settle(
    table: GasParticles,
    solid: GasSolid,
    quiet: bool,
    engine: Literal["contbed", "cuda"],
) -> Particles:
    """Settle the particles from a random start."""
    assert solid.radius is not None
    packing = pack(
        table.width,
        radius=solid.radius,
        count=table.count,
        seed=table.seed,
        material=Material.of(solid, table.modulus),
        periodic=(table.periodic, table.periodic),
        quiet=quiet,
        engine=engine,
    )
    return Particles(_wrapped(packing.position, packing.radius, table), packing.radius)


def _wrapped(position: Any, radius: Any, table: GasParticles) -> Any:
    """Return centres, of which those that are beyond a periodic side by less than a
    radius enter by the side opposite.
    """
    if not table.periodic:
        return position
    position, widths = position.copy(), np.array(table.width)
    sides = position[:, : len(widths)]
    beyond = np.maximum(-sides, sides - widths)
    passed = (beyond > 0.0) & (beyond < np.reshape(radius, (-1, 1)))
    sides[passed] = wrapped(sides, 0.0, widths, True)[passed]
    return position


def read(table: GasParticles, solid: GasSolid, base: Path) -> Particles:
    """Read the particles of the file, looked for in `base`: at rest if the scene or the
    file says so.

    Their positions count from the lower corner of the box of a dump.
    """
    assert table.file is not None
    found = read_particles(base / table.file, solid.radius)
    velocity = 0.0 if table.fixed or found.velocity is None else found.velocity
    x = found.x - (0.0 if found.low is None else found.low)
    return Particles(
        _wrapped(x, found.radius, table),
        found.radius,
        velocity=velocity,
    )


def at_start(
    table: GasParticles, solid: GasSolid, tubes: Sequence[BedTube], base: Path
) -> tuple[Particles, int]:
    """Read the particles of the file, and leave out those that lie in tubes, whose
    number follows.
    """
    found = read(table, solid, base)
    return _outside_of_tubes(found, tubes, _largest_overlap(table, solid, found))


def require_room(table: GasParticles, particles: Particles, origin: Origin) -> None:
    """Refuse particles whose centres are outside of the box.

    Raises
    ------
    SceneError : names the key that is too small and its line
    """
    room = (*table.width, table.height)
    for axis, key in enumerate(
        ("particles.width", "particles.width", "particles.height")
    ):
        centre = particles.position[:, axis]
        if centre.min() < 0.0 or centre.max() > room[axis]:
            where = origin.at(tuple(key.split(".")))
            raise SceneError(
                f"{where}: {key}: centres from {centre.min():.4g} to "
                f"{centre.max():.4g} m in {'xyz'[axis]}, "
                f"the box from 0 to {room[axis]:.4g} m"
            )
