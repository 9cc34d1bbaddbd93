"""Packings: spheres placed at random, settled soft under gravity, then stiffened to the
    wanted modulus.

Soft contacts take long time steps, and the energy kept in overlaps is below 1 % of m g
d, so that stiffening hardly moves the bed. Restitution stays that of the material: 0.2
in place of 0.9 would leave a bed looser by 0.01 of porosity, with 4 % less
conductivity. The same arguments and seed give the same packing.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from contbed.arrays import Array, Flags, Integers
from contbed.compiled.functions import entry
from contbed.dem.particles import Material, Particles
from contbed.dem.scene import SOLID_SHARE
from contbed.dem.settling import CHECK_EVERY, IMPACT, Stage, not_at_rest, stages_of
from contbed.dem.simulation import Contacts, Simulation
from contbed.dem.statistics import coordination, porosity, surface
from contbed.dem.walls import (
    INFINITE,
    REACHES,
    SKIN,
    Cylinder,
    Domain,
    Plane,
    Wall,
    box,
)
from contbed.errors import ConvergenceError, SceneError

LOOSE = 0.28  # solid fraction at the start; placing at random jams at 0.38
AT_REST = 1e-6  # kinetic energy over N m g d
# share of it that the motion of centres has where spheres only spin on the spot or roll
# on by less than a tenth of a millimetre a second
ON_THE_SPOT = 1e-3
TRIES = 2000  # for one sphere
COLUMN = 5.0  # diameters
# of the smallest radius, room of the lists of spheres that settle on a GPU, where a
# list takes as long as four steps: a million that fall take 1.7 ms a step, 3.5 with the
# 0.1 of processors; at rest 1.2 and 1.7 (H100)
GPU_SKIN = 0.6
# of the smaller radius, accepted of spheres that have settled by their own weight
SETTLED_OVERLAP = 0.5


@dataclass(frozen=True)
class Packing:
    """A settled bed on the floor z = 0.

    `position` [m] (n, 3), `radius` [m]; `domain` holds the box and its periodic sides,
    `cylinder` the radius [m] of a round bed or None; `walls` and `domain` are those of
    a `Simulation` that resumes; `contacts` of pairs; `statistics`: count, height and
    mean surface [m], porosity, coordination, overlaps over the diameter, kinetic energy
    over N m g d.
    """

    position: Array
    radius: Array
    material: Material
    domain: Domain
    walls: tuple[Wall, ...]
    cylinder: float | None
    contacts: Contacts
    statistics: dict[str, float]

    def __len__(self) -> int:
        return len(self.position)


def pack(
    width: tuple[float, float] | None = None,
    *,
    cylinder: float | None = None,
    radius: ArrayLike = 1e-3,
    count: int | None = None,
    height: float | None = None,
    material: Material | None = None,
    periodic: tuple[bool, bool] = (False, False),
    seed: int = 0,
    at_rest: float = AT_REST,
    gravity: float = 9.81,
    quiet: bool = True,
    engine: Literal["contbed", "lammps", "cuda"] = "contbed",
    folder: Path | None = None,
    skin: float | None = None,
    kinetic_damping: bool = False,
) -> Packing:
    """Settle a random loose packing in a box or a cylinder.

    Parameters
    ----------
    width [m] : of the box in x and y; or `cylinder` [m], the radius of a round bed
    radius [m] : of all spheres, or an array of radii, one for each
    count : number of spheres; or `height` [m], about as many as fill the bed to there
    periodic : sides in x and y of a box
    at_rest : kinetic energy over N m g d at which the bed counts as settled
    gravity [m/s2], downwards
    quiet : no progress bar
    engine : which program moves the spheres, from the same start; "lammps" needs
        contbed[lammps], and takes as many ranks of MPI as `threads.using` says, one
        without it; "cuda" needs a GPU from NVIDIA and contbed[cuda]
    folder : where the input and the log of LAMMPS are kept
    skin : room of the lists of neighbours [m], a tenth of the smallest radius by
        default; with wider ones spheres that fall far settle faster, to another packing
        of the same kind
    kinetic_damping : stop all spheres whenever their kinetic energy falls, once they
        have landed (dynamic relaxation, Barnes 1999, Int. J. Space Struct. 14, 89-104);
        beds hundreds of diameters deep bounce for long without it, and are denser then,
        by 0.008 of porosity at 100 diameters

    Raises
    ------
    SceneError : both or neither of two alternatives, a bed narrower than a sphere,
        rolling friction or kinetic damping for LAMMPS
    EngineError : LAMMPS or the GPU is not there, or LAMMPS stops with an error
    ConvergenceError : the bed does not come to rest
    """
    if (width is None) == (cylinder is None):
        raise SceneError("packing: give either width or cylinder")
    if cylinder is not None and any(periodic):
        raise SceneError("packing: a cylinder has no periodic sides")
    sides = (2.0 * cylinder, 2.0 * cylinder) if cylinder is not None else width
    assert sides is not None
    area = np.pi * cylinder**2 if cylinder is not None else sides[0] * sides[1]
    radii = _radii(radius, count, height, area)
    if 2.0 * radii.max() > min(sides):
        raise SceneError(
            f"packing: spheres of {2.0 * radii.max():g} m do not fit into a bed "
            f"{min(sides):g} m wide"
        )
    material = material or Material()
    rng = np.random.default_rng(seed)
    domain, walls = _container(sides, cylinder, periodic)
    position = _place(rng, radii, sides, cylinder, periodic, area)
    bed = Particles(position, radii)
    stages = stages_of(bed, material, at_rest, gravity)
    if engine == "lammps":
        if kinetic_damping:
            raise SceneError(
                "packing: LAMMPS settles without kinetic damping; leave it out, or use "
                "another engine"
            )
        from contbed.dem.lammps_run import settle

        final, unrest = settle(bed, domain, walls, stages, gravity, folder, quiet)
        contacts = _at(Particles(final, radii), material, walls, domain).contacts()
    else:
        if engine == "cuda" and skin is None:
            skin = _gpu_skin(radii, domain)
        for stage in stages:
            simulation = _at(
                bed,
                stage.material,
                walls,
                domain,
                gravity=(0.0, 0.0, -gravity),
                time_step=stage.time_step,
                skin=skin,
                engine=engine,
            )
            _settle(simulation, stage, gravity, quiet, kinetic_damping)
            bed = Particles(simulation.position, radii)
        final = bed.position
        contacts = simulation.contacts()
        unrest = _unrest(simulation, gravity)
    statistics = {
        "count": float(len(radii)),
        "height": float(np.max(final[:, 2] + radii)),
        "surface": surface(final, radii),
        **porosity(final, radii, domain, cylinder),
        **coordination(final, radii, contacts, domain, cylinder),
        "overlap_mean": float(np.sum(_relative(contacts, radii)))
        / max(len(contacts), 1),
        "overlap_max": float(np.max(_relative(contacts, radii), initial=0.0)),
        "kinetic_energy": unrest,
    }
    return Packing(
        final, radii, material, domain, tuple(walls), cylinder, contacts, statistics
    )


def loose_height(radii: Array, area: float) -> float:
    """Return the height [m] of spheres (n,) [m] over a floor [m2] before they
    settle.
    """
    return float(4.0 / 3.0 * np.pi * (radii**3).sum() / (LOOSE * area))


def _radii(
    radius: ArrayLike, count: int | None, height: float | None, area: float
) -> Array:
    radii = np.atleast_1d(np.asarray(radius, dtype=np.float64))
    if not (radii > 0.0).all() or radii.ndim != 1:
        raise SceneError("packing: radii must be positive")
    if len(radii) > 1:
        if height is not None or count not in (None, len(radii)):
            raise SceneError(
                f"packing: {len(radii)} radii fix the number of spheres; leave out "
                "count and height"
            )
        return radii
    if (count is None) == (height is None):
        raise SceneError("packing: give either count or height")
    if count is None:
        assert height is not None
        count = round(SOLID_SHARE * area * height / (4.0 / 3.0 * np.pi * radii[0] ** 3))
    if count < 1:
        raise SceneError(
            f"packing: {count} spheres; the bed is too low or the count is not positive"
        )
    return np.full(count, radii[0])


def _container(
    sides: tuple[float, float], cylinder: float | None, periodic: tuple[bool, bool]
) -> tuple[Domain, list[Wall]]:
    if cylinder is not None:
        domain = Domain((-cylinder, -cylinder, 0.0), (cylinder, cylinder, INFINITE))
        walls: list[Wall] = [
            Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
            Cylinder((0.0,) * 3, (0.0, 0.0, 1.0), cylinder),
        ]
        return domain, walls
    domain = Domain((0.0, 0.0, 0.0), (sides[0], sides[1], INFINITE), (*periodic, False))
    return domain, [*box(domain)]


def _place(
    rng: np.random.Generator,
    radii: Array,
    sides: tuple[float, float],
    cylinder: float | None,
    periodic: tuple[bool, bool],
    area: float,
) -> Array:
    """Draw positions without overlap; equal spheres are numbered column by column,
    which keeps memory near.
    """
    top = loose_height(radii, area) + 2.0 * radii.max()
    limits = np.array([sides[0], sides[1], top])
    order = np.argsort(-radii, kind="stable")
    for _ in range(8):
        placed, position = _add_at_random(
            radii, order, limits, cylinder or 0.0, np.array(periodic), rng
        )
        if placed:
            if np.ptp(radii) > 0.0:
                return np.asarray(position)
            column = np.floor(position[:, :2] / (COLUMN * 2.0 * radii[0]))
            return np.asarray(
                position[np.lexsort((position[:, 2], column[:, 1], column[:, 0]))]
            )
        limits[2] *= 1.2
    raise ConvergenceError(
        f"packing: no room for {len(radii)} spheres in a bed {min(sides):g} m wide; "
        "widen it"
    )


@entry(cache=True)
def _add_at_random(
    radius: Array,
    order: Integers,
    limits: Array,
    cylinder: float,
    periodic: Flags,
    rng: np.random.Generator,
) -> tuple[bool, Array]:
    """Add spheres at random, large ones first by `order`; return whether all found a
    place, and positions [m].
    """
    n, top = len(radius), radius[order[0]]
    x = np.zeros((n, 3))
    count = np.empty(3, np.int64)
    for axis in range(3):
        count[axis] = max(1, int(limits[axis] / (2.0 * top)))
    head = np.full((count[0], count[1], count[2]), -1, np.int64)
    after = np.full(n, -1, np.int64)
    at, p, low = np.empty(3, np.int64), np.empty(3), np.empty(3)
    for axis in range(3):
        low[axis] = -0.5 * limits[axis] if cylinder > 0.0 and axis < 2 else 0.0
    for i in order:
        free = False
        for _ in range(TRIES):
            for axis in range(3):
                edge = 0.0 if axis < 2 and periodic[axis] else radius[i]
                p[axis] = low[axis] + edge + (limits[axis] - 2.0 * edge) * rng.random()
                at[axis] = min(
                    int((p[axis] - low[axis]) / limits[axis] * count[axis]),
                    count[axis] - 1,
                )
            if cylinder > 0.0 and p[0] ** 2 + p[1] ** 2 > (cylinder - radius[i]) ** 2:
                continue
            free = True
            for step in range(27):
                a = at[0] + step % 3 - 1
                b = at[1] + step // 3 % 3 - 1
                c = at[2] + step // 9 - 1
                if c < 0 or c >= count[2]:
                    continue
                if not (periodic[0] or 0 <= a < count[0]) or not (
                    periodic[1] or 0 <= b < count[1]
                ):
                    continue
                j = head[a % count[0], b % count[1], c]
                while j >= 0 and free:
                    dx, dy, dz = p[0] - x[j, 0], p[1] - x[j, 1], p[2] - x[j, 2]
                    if periodic[0]:
                        dx -= limits[0] * np.rint(dx / limits[0])
                    if periodic[1]:
                        dy -= limits[1] * np.rint(dy / limits[1])
                    free = dx * dx + dy * dy + dz * dz > (radius[i] + radius[j]) ** 2
                    j = after[j]
                if not free:
                    break
            if free:
                break
        if not free:
            return False, x
        # to assign a row makes the compiler build numba's functions of texts, for its
        # error
        for axis in range(3):
            x[i, axis] = p[axis]
        after[i] = head[at[0], at[1], at[2]]
        head[at[0], at[1], at[2]] = i
    return True, x


def _at(
    bed: Particles, material: Material, walls: list[Wall], domain: Domain, **motion: Any
) -> Simulation:
    """Make a simulation of spheres that may overlap as those of a settled bed do."""
    return Simulation(
        bed,
        [material],
        walls,
        domain,
        impact_speed=IMPACT,
        largest_overlap=SETTLED_OVERLAP,
        **motion,
    )


def _settle(
    simulation: Simulation,
    stage: Stage,
    gravity: float,
    quiet: bool,
    kinetic_damping: bool,
) -> None:
    """Take the steps of a stage until the spheres are at rest, but for spin on the
    spot, which no contact law brakes.
    """
    unrest, before, has_landed, rests = np.inf, 0.0, False, False

    def ends(bed: Simulation) -> bool:
        nonlocal unrest, before, has_landed, rests
        unrest = _unrest(bed, gravity)
        rests = unrest < stage.at_rest
        rests |= _motion(bed, gravity) < ON_THE_SPOT * stage.at_rest
        if rests:
            return True
        # the bed as a whole rebounds
        has_landed |= bool(bed.mass @ bed.velocity[:, 2] > 0.0)
        before, falls = unrest, unrest < before
        if kinetic_damping and has_landed and falls:
            bed.velocity[:], bed.spin[:], before = 0.0, 0.0, 0.0
        return False

    simulation.run(stage.steps, CHECK_EVERY, ends, quiet)
    if not rests:
        raise ConvergenceError(not_at_rest(stage, unrest), state=simulation.state())


def _gpu_skin(radii: Array, domain: Domain) -> float:
    """Return the skin of lists on a GPU [m], less where periodic sides are near each
    other.
    """
    lengths = np.subtract(domain.upper, domain.lower)[np.array(domain.periodic)]
    room = float(lengths.min(initial=INFINITE)) / REACHES - 2.0 * float(radii.max())
    skin = GPU_SKIN * float(radii.min())
    return skin if room >= skin else max(room, SKIN * float(radii.min()))


def _unrest(simulation: Simulation, gravity: float) -> float:
    """Return the kinetic energy over N m g d."""
    return simulation.kinetic_energy / _scale(simulation, gravity)


def _motion(simulation: Simulation, gravity: float) -> float:
    """Return the kinetic energy without that of spin over N m g d."""
    speed2 = (simulation.velocity**2).sum(axis=1)
    return 0.5 * float(simulation.mass @ speed2) / _scale(simulation, gravity)


def _scale(simulation: Simulation, gravity: float) -> float:
    """Return N m g d [J]."""
    return float((simulation.mass * 2.0 * simulation.radius).sum() * gravity)


def _relative(contacts: Contacts, radii: Array) -> Array:
    """Return overlaps over the diameter of the smaller sphere."""
    return np.asarray(
        contacts.overlap / (2.0 * np.minimum(radii[contacts.i], radii[contacts.j]))
    )
