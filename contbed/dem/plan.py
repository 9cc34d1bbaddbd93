"""What a run of a scene of particles builds: the assembly, its box and its porosity;
a packing settles in the run.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from contbed.arrays import Array
from contbed.dem.particle_files import read_particles
from contbed.dem.particles import Material
from contbed.dem.scene import Lattice, Layers, Packing, ParticleScene
from contbed.dem.sizes import random_radii
from contbed.errors import EngineError, SceneError
from contbed.models import Plan
from contbed.plan_text import plan_text
from contbed.solvers.memory import MemoryPerUnknown

PACKING = ("particles", "packing")  # key of the table
# diameters from the floor and from the surface, where the layers of a packing end
BOTTOM, TOP = 1.0, 2.0

# bytes for each temperature, with the paths of its particle: 2000 by contacts, 3700
# through a fluid
MEMORY = MemoryPerUnknown(4e3)

# centres in the unit cell, and the edge of the cell over the radius of spheres that
# touch
_CORNERS = {
    "sc": [[0, 0, 0]],
    "bcc": [[0, 0, 0], [0.5, 0.5, 0.5]],
    "fcc": [[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]],
}
_EDGE = {"sc": 2.0, "bcc": 4.0 / 3.0**0.5, "fcc": 2.0 * 2.0**0.5}


@dataclass(frozen=True)
class ParticlePlan:
    """What a run builds: particles, the box they are in, whether it is periodic.

    A packing has no particles before it is settled; `engine` says by which program.
    """

    scene: ParticleScene
    x: Array
    radius: Array
    box: tuple[Array, Array]
    periodic: tuple[bool, ...]
    porosity: float
    layers: Layers | None
    built: tuple[tuple[str, str], ...]
    skipped: tuple[tuple[str, str], ...]
    mesh: None = None
    policy: MemoryPerUnknown = MEMORY
    steps: bool = False
    engine: Literal["contbed", "lammps", "cuda"] = "contbed"

    def unknowns(self) -> dict[str, int]:
        """Count the unknowns: the temperatures."""
        packing = self.scene.particles.packing
        return {
            "heat": len(self.x) if packing is None else packing.number(self.scene.solid)
        }

    def on_gpu(self) -> ParticlePlan:
        """Return the plan of a packing that settles on a GPU.

        Raises
        ------
        EngineError : the scene has no packing
        """
        if self.scene.particles.packing is None:
            raise EngineError(
                f"{self.scene.origin.name}: --engine cuda settles the "
                "[particles.packing] of a scene; "
                "this scene has none, leave the option out"
            )
        return replace(self, engine="cuda", built=particles_by(self.built, "on a GPU"))

    def __str__(self) -> str:
        return plan_text(self)


def particles_by(
    built: tuple[tuple[str, str], ...], where: str
) -> tuple[tuple[str, str], ...]:
    """Say of the particles among what is built where they are computed."""
    return tuple(
        (what, f"{how} {where}" if what == "particles" else how) for what, how in built
    )


def plan(scene: ParticleScene) -> ParticlePlan:
    """Read or make the particles.

    Raises
    ------
    SceneError : the file of particles cannot be used
    """
    table = scene.particles
    if table.packing is not None:
        x, radius, porosity = np.empty((0, 3)), np.empty(0), float("nan")
        box = np.zeros(3), np.zeros(3)
        periodic: tuple[bool, ...] = (
            table.packing.periodic,
            table.packing.periodic,
            False,
        )
        what = f"{table.packing.number(scene.solid)}, settled from a random start"
    else:
        x, radius, box, periodic = (
            _from_file(scene)
            if table.lattice is None
            else _lattice(table.lattice, scene)
        )
        porosity = table.porosity or porosity_of(table.layers, x, radius, box)
        what = f"{len(x)}, porosity {porosity:.4g}"
    is_cell = table.layers is None and table.packing is None
    built = [
        ("particles", what),
        ("network", "periodic cell, full tensor" if is_cell else "between layers"),
    ]
    skipped: list[tuple[str, str]] = []
    for there, what, how, why in (
        (scene.gas is not None, "heat through the gas", table.paths, "no [gas] table"),
        (
            scene.radiation is not None,
            "radiation",
            "reciprocal, linear",
            "no [radiation] table",
        ),
        (
            table.closure is not None,
            "closure file",
            "log-polynomial",
            "no [particles.closure] table",
        ),
    ):
        (built if there else skipped).append((what, how if there else why))
    return ParticlePlan(
        scene,
        x,
        radius,
        box,
        periodic,
        porosity,
        table.layers,
        tuple(built),
        tuple(skipped),
    )


def settled(plan: ParticlePlan, folder: Path | None, quiet: bool) -> ParticlePlan:
    """Settle the packing of a scene; return the plan with its particles, box, layers
    and porosity.

    Parameters
    ----------
    plan : of a scene with a packing
    folder : where LAMMPS keeps its files
    quiet : no progress bar

    Raises
    ------
    SceneError : the spheres do not fit, or the bed is too low for its layers
    EngineError : LAMMPS stops with an error
    ConvergenceError : the bed does not come to rest
    """
    from contbed.dem.packing import pack

    scene, table = plan.scene, plan.scene.particles.packing
    assert table is not None
    bed = pack(
        table.width,
        cylinder=table.cylinder,
        radius=_radii(scene, table),
        material=_material(scene),
        periodic=(table.periodic, table.periodic),
        seed=table.seed,
        quiet=quiet,
        engine=plan.engine,
        folder=folder,
    )
    x, radius = bed.position, bed.radius
    low = np.array(bed.domain.lower)
    high = np.array([*bed.domain.upper[:2], float((x[:, 2] + radius).max())])
    diameter = scene.solid.diameter
    assert diameter is not None
    layers = scene.particles.layers or Layers(
        bottom=BOTTOM * diameter, top=bed.statistics["surface"] - TOP * diameter
    )
    layers = layers.model_copy(update={"area": table.area})
    if not layers.bottom < layers.top < high[2]:
        raise SceneError(
            f"{scene.origin.place(PACKING)}: the bed is "
            f"{bed.statistics['surface']:.4g} m high, "
            f"too low for layers below {layers.bottom:.4g} m and above "
            f"{layers.top:.4g} m; "
            "take more spheres, or a narrower bed"
        )
    porosity = scene.particles.porosity or porosity_of(layers, x, radius, (low, high))
    return replace(
        plan, x=x, radius=radius, box=(low, high), porosity=porosity, layers=layers
    )


def _radii(scene: ParticleScene, table: Packing) -> Array:
    """Draw the radii of a packing [m]."""
    solid = scene.solid
    assert solid.radius is not None
    return random_radii(
        solid.radius, solid.size_spread, table.number(solid), table.seed
    )


def _material(scene: ParticleScene) -> Material:
    """Return the material of the simulation of a packing."""
    modulus = scene.particles.simulated_modulus
    assert modulus is not None
    return Material.of(scene.solid, modulus)


def on_lammps(plan: Plan) -> ParticlePlan:
    """Return the plan of a packing that LAMMPS settles.

    Raises
    ------
    EngineError : the scene has no packing, or LAMMPS is not installed
    SceneError : a law of the scene that LAMMPS does not have
    """
    from contbed.dem.lammps_deck import rolling_refused
    from contbed.dem.lammps_run import find_program

    scene = plan.scene
    if not isinstance(plan, ParticlePlan) or plan.scene.particles.packing is None:
        raise EngineError(
            f"{scene.origin.name}: --engine lammps settles the [particles.packing] of "
            "a scene; this scene of kind "
            f"{scene.kind} has none, leave the option out"
        )
    friction = plan.scene.solid.rolling_friction
    if friction > 0.0:
        where = scene.origin.at(("solids", *scene.solids, "rolling_friction"))
        raise SceneError(f"{where}: {rolling_refused(friction)}")
    find_program()
    return replace(plan, engine="lammps", built=particles_by(plan.built, "by LAMMPS"))


def _lattice(
    table: Lattice, scene: ParticleScene
) -> tuple[Array, Array, tuple[Array, Array], tuple[bool, ...]]:
    """Return centres, radii, box and periodic sides of a lattice."""
    radius = scene.solid.radius
    assert radius is not None
    edge = _EDGE[table.type] * radius
    steps = np.arange(table.cells)
    origins = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(
        -1, 1, 3
    )
    x = ((origins + np.array(_CORNERS[table.type])) * edge).reshape(-1, 3)
    return (
        x,
        np.full(len(x), radius),
        (np.zeros(3), np.full(3, edge * table.cells)),
        (True, True, True),
    )


def _from_file(
    scene: ParticleScene,
) -> tuple[Array, Array, tuple[Array, Array], tuple[bool, ...]]:
    """Read centres, radii, box and periodic sides; layers open the axis that heat
    flows along.
    """
    table = scene.particles
    assert table.file is not None
    found = read_particles(scene.origin.base / table.file, scene.solid.radius)
    periodic = found.periodic if table.layers is None else (*found.periodic[:2], False)
    return found.x, found.radius, found.box, periodic


def porosity_of(
    layers: Layers | None, x: Array, radius: Array, box: tuple[Array, Array]
) -> float:
    """Find the porosity of the periodic box, or that between the layers, whose
    planes cut spheres.
    """
    if layers is None:
        return float(
            1.0 - (4.0 / 3.0 * np.pi * radius**3).sum() / np.prod(box[1] - box[0])
        )
    assert layers.area is not None
    low, high, area = layers.bottom, layers.top, layers.area
    # volume of a sphere below a plane at height h above its centre: pi (2 R^3/3 + R^2 h
    # - h^3/3)
    below = []
    for plane in (low, high):
        h = np.clip(plane - x[:, 2], -radius, radius)
        below.append(np.pi * (2.0 / 3.0 * radius**3 + radius**2 * h - h**3 / 3.0))
    return float(1.0 - (below[1] - below[0]).sum() / (area * (high - low)))
