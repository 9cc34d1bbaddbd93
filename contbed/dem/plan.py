"""What a run of a scene of particles builds: the assembly, its box and its porosity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.dem.particle_files import read_particles
from contbed.dem.scene import Lattice, Layers, ParticleScene
from contbed.models import described

Array = NDArray[np.float64]

# centres in the unit cell, and the edge of the cell over the radius of spheres that touch
_CORNERS = {
    "sc": [[0, 0, 0]],
    "bcc": [[0, 0, 0], [0.5, 0.5, 0.5]],
    "fcc": [[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]],
}
_EDGE = {"sc": 2.0, "bcc": 4.0 / 3.0**0.5, "fcc": 2.0 * 2.0**0.5}


@dataclass(frozen=True)
class ParticlePlan:
    """What a run builds: particles, the box they are in, whether it is periodic."""

    scene: ParticleScene
    x: Array
    radius: Array
    box: tuple[Array, Array]
    periodic: tuple[bool, ...]
    porosity: float
    built: tuple[tuple[str, str], ...]
    skipped: tuple[tuple[str, str], ...]
    mesh: None = None
    without_weak_form: str = "scenes of kind particles"
    steps: bool = False

    @property
    def policy(self) -> Any:
        """How linear systems are solved."""
        from contbed.solvers.linear import Policy

        return Policy(3, None)

    def unknowns(self) -> dict[str, int]:
        """Count the unknowns: the temperatures."""
        return {"heat": len(self.x)}

    def __str__(self) -> str:
        return described(self)


def plan(scene: ParticleScene) -> ParticlePlan:
    """Read or make the particles.

    Raises
    ------
    SceneError : the file of particles cannot be used
    """
    if scene.lattice is not None:
        x, radius, box, periodic = _lattice(scene.lattice)
    else:
        x, radius, box, periodic = _from_file(scene)
    porosity = scene.conduction.porosity or porosity_of(scene.layers, x, radius, box)
    how = "between layers" if scene.layers is not None else "periodic cell, full tensor"
    built = [("particles", f"{len(x)}, porosity {porosity:.4g}"), ("network", how)]
    skipped: list[tuple[str, str]] = []
    for there, what, how, why in (
        (scene.conduction.fluid is not None, "heat through the fluid", scene.conduction.paths, "no conduction.fluid"),
        (scene.radiation is not None, "radiation", "reciprocal, linear", "no [radiation] table"),
        (scene.closure is not None, "closure file", "log-polynomial", "no [closure] table"),
    ):
        (built if there else skipped).append((what, how if there else why))
    return ParticlePlan(scene, x, radius, box, periodic, porosity, tuple(built), tuple(skipped))


def _lattice(table: Lattice) -> tuple[Array, Array, tuple[Array, Array], tuple[bool, ...]]:
    edge = _EDGE[table.type] * table.radius
    steps = np.arange(table.cells)
    origins = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(-1, 1, 3)
    x = ((origins + np.array(_CORNERS[table.type])) * edge).reshape(-1, 3)
    return x, np.full(len(x), table.radius), (np.zeros(3), np.full(3, edge * table.cells)), (True, True, True)


def _from_file(scene: ParticleScene) -> tuple[Array, Array, tuple[Array, Array], tuple[bool, ...]]:
    """Read centres, radii, box and periodic sides; layers open the axis that heat flows along."""
    table = scene.particles
    assert table is not None
    found = read_particles(scene.origin.base / table.file, table.radius, table.step)
    periodic = found.periodic if scene.layers is None else (*found.periodic[:2], False)
    return found.x, found.radius, found.box, periodic


def porosity_of(layers: Layers | None, x: Array, radius: Array, box: tuple[Array, Array]) -> float:
    """Find the porosity of the periodic box, or that between the layers, whose planes cut spheres."""
    if layers is None:
        return float(1.0 - (4.0 / 3.0 * np.pi * radius**3).sum() / np.prod(box[1] - box[0]))
    low, high, area = layers.bottom, layers.top, layers.area
    # volume of a sphere below a plane at height h above its centre: pi (2 R^3/3 + R^2 h - h^3/3)
    below = []
    for plane in (low, high):
        h = np.clip(plane - x[:, 2], -radius, radius)
        below.append(np.pi * (2.0 / 3.0 * radius**3 + radius**2 * h - h**3 / 3.0))
    return float(1.0 - (below[1] - below[0]).sum() / (area * (high - low)))
