"""Plan and run of a scene of particles: the assembly, its network, effective conductivity, closure file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.balance import Balance
from contbed.dem import dumps, extract, heat, network
from contbed.dem import scene as p
from contbed.dem.heat_pair import correction
from contbed.errors import SceneError
from contbed.fields import header
from contbed.models import described
from contbed.result import Result, timed

Array = NDArray[np.float64]

_CORNERS = {
    "sc": [[0, 0, 0]],
    "bcc": [[0, 0, 0], [0.5, 0.5, 0.5]],
    "fcc": [[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]],
}
_EDGE = {"sc": 2.0, "bcc": 4.0 / 3.0**0.5, "fcc": 2.0 * 2.0**0.5}  # of the unit cell over the radius
_TOUCH = 1e-9  # relative reach beyond contact, for the rounding of a lattice's coordinates


@dataclass(frozen=True)
class ParticlePlan:
    """What a run builds: particles, the box they are in, whether it is periodic."""

    scene: p.ParticleScene
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
        """Number of unknowns: the temperatures."""
        return {"heat": len(self.x)}

    def __str__(self) -> str:
        return described(self)


def plan(scene: p.ParticleScene) -> ParticlePlan:
    """Read or make the particles."""
    if scene.lattice is not None:
        x, radius, box, periodic = _lattice(scene.lattice)
    else:
        x, radius, box, periodic = _from_file(scene)
    porosity = scene.conduction.porosity or _porosity(scene, x, radius, box)
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


@timed("heat")
def run(plan: Any, result: Result, folder: Path | None, quiet: bool, start: Any) -> None:
    """Solve the network and fill the result; a closure file goes into `folder`, `quiet` and `start` have no use."""
    scene = plan.scene
    pairs = _pairs(plan)
    parts = _parts(plan, pairs, scene.conduction.particles)
    found = _conductivity(plan, pairs, parts, result)
    contacts = int((parts["contact"] > 0).sum())
    result.qoi |= {"porosity": plan.porosity, "coordination": 2.0 * contacts / len(plan.x), "k_eff [W/m/K]": found}
    if scene.conduction.fluid is not None:
        result.qoi["k_eff_over_k_fluid"] = found / scene.conduction.fluid
    if scene.lattice is not None:
        k, lattice = scene.conduction.particles, scene.lattice
        result.qoi["k_eff_over_contact_scale"] = found * lattice.radius / (k * lattice.contact_radius * _factor(scene))
    if scene.closure is not None:
        _closure(plan, pairs, result, folder)


def _closure(plan: ParticlePlan, pairs: heat.Pairs, result: Result, folder: Path | None) -> None:
    from contbed.scene.identity import scene_hash

    scene = plan.scene
    table, fluid = scene.closure, scene.conduction.fluid
    assert table is not None and fluid is not None
    ratios = np.unique(table.ratios)
    k = [_conductivity(plan, pairs, _parts(plan, pairs, ratio * fluid), None) / fluid for ratio in ratios]
    data = {extract.RATIO: ratios, "eps": np.full(len(ratios), plan.porosity)}
    fit = extract.fit_log_polynomial("conductivity", data, k, {extract.RATIO: "log"}, (table.degree,))
    result.qoi["closure_residual"] = fit.content["residuals"]["largest"]
    if folder is not None:
        fit.write(folder / "closure.toml", {"scene": Path(scene.origin.name).name, "scene_hash": scene_hash(scene)})


def _conductivity(plan: ParticlePlan, pairs: heat.Pairs, parts: dict[str, Array], result: Result | None) -> float:
    """Effective conductivity [W/m/K], of a periodic cell the mean of the axes; fills the result if there is one."""
    layers = plan.scene.layers
    if layers is None:
        volume = float(np.prod(plan.box[1] - plan.box[0]))
        cell = network.periodic_cell(len(plan.x), pairs, parts, volume)
        k = float(np.trace(cell.conductivity)) / 3.0
        if result is not None:
            names = "xyz"
            result.qoi |= {
                f"k_{names[a]}{names[b]} [W/m/K]": float(cell.conductivity[a, b]) for a in range(3) for b in range(a, 3)
            }
            result.qoi |= {f"share_{name}": float(np.trace(t)) / 3.0 / k for name, t in cell.parts.items()}
        return k
    z = plan.x[:, 2]
    found = network.between_layers(
        plan.x, pairs, parts, z < layers.bottom, z > layers.top, layers.area, layers.T_hot, layers.T_cold
    )
    if result is not None:
        result.qoi |= {f"share_{name}": share for name, share in found.shares.items()}
        result.qoi |= {"heat [W]": found.heat, "k_between_layers [W/m/K]": found.between, "isolated": found.isolated}
        result.balances["energy"] = Balance(
            found.heat, found.heat * (1.0 - found.imbalance), "W", scale=abs(found.heat)
        ).as_dict()
        result.profiles |= _profile(z, found.T, float(plan.radius.mean()))
    return found.conductivity


def _profile(z: Array, T: Array, step: float) -> dict[str, Array]:
    """Mean height and temperature of the particles in slices one radius thick."""
    known = np.isfinite(T)
    slot = ((z[known] - z[known].min()) / step).astype(int)
    count = np.bincount(slot)
    kept = count > 0
    means = [np.bincount(slot, value[known])[kept] / count[kept] for value in (z, T)]
    return {header("z"): means[0], header("T_solid"): means[1]}


def _parts(plan: ParticlePlan, pairs: heat.Pairs, k: float) -> dict[str, Array]:
    scene = plan.scene
    table, lattice = scene.conduction, scene.lattice
    how = heat.Conduction(
        k, table.fluid, plan.porosity, _factor(scene), None if lattice is None else lattice.contact_radius, table.paths
    )
    equal = np.ptp(plan.radius) == 0
    parts = heat.conductances(pairs, plan.radius[0] if equal else plan.radius, how)
    if scene.radiation is not None:
        d = 2.0 * float(plan.radius.mean())
        parts["radiation"] = heat.radiation_conductance(
            pairs, len(plan.x), scene.radiation.temperature, d, scene.radiation.emissivity, plan.porosity
        )
    return parts


def _pairs(plan: ParticlePlan) -> heat.Pairs:
    table = plan.scene.conduction
    if table.paths == "columns":
        if plan.scene.radiation is not None or np.ptp(plan.radius) > 0:
            where = plan.scene.origin.at(("conduction", "paths")) + ": conduction.paths"
            raise SceneError(f"{where}: columns are for equal particles without [radiation]; use cones")
        return heat.voronoi_pairs(plan.x, plan.box, plan.periodic)
    reach = 2.0 * float(plan.radius.max())
    reach *= heat.VIEW if table.fluid is not None or plan.scene.radiation is not None else 1.0 + _TOUCH
    return heat.near_pairs(plan.x, reach, plan.box, plan.periodic)


def _factor(scene: p.ParticleScene) -> float:
    table = scene.conduction.correction
    return 1.0 if table is None else float(correction(table.simulated, table.real, table.exponent))


def _lattice(table: p.Lattice) -> tuple[Array, Array, tuple[Array, Array], tuple[bool, ...]]:
    edge = _EDGE[table.type] * table.radius
    steps = np.arange(table.cells)
    origins = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(-1, 1, 3)
    x = ((origins + np.array(_CORNERS[table.type])) * edge).reshape(-1, 3)
    return x, np.full(len(x), table.radius), (np.zeros(3), np.full(3, edge * table.cells)), (True, True, True)


def _from_file(scene: p.ParticleScene) -> tuple[Array, Array, tuple[Array, Array], tuple[bool, ...]]:
    table = scene.particles
    assert table is not None
    path = scene.origin.base / table.file
    if dumps.is_dump(path):
        frame = _frame(scene, dumps.read_dump(path))
        x, radius, box, periodic = frame.x, frame.radius, (frame.low, frame.high), frame.periodic
        if table.radius is not None:
            radius = np.full(len(x), table.radius)
    else:
        if table.radius is None:
            raise SceneError(f"{scene.origin.at(('particles',))}: particles.radius: missing; {table.file} has none")
        x, periodic = dumps.read_positions(path), heat.CLOSED
        radius = np.full(len(x), table.radius)
        box = (x - radius[:, None]).min(axis=0), (x + radius[:, None]).max(axis=0)
    if scene.layers is None and not all(periodic):
        raise SceneError(
            f"{scene.origin.at(('particles',))}: layers: this table is missing; the box of {table.file} "
            "is not periodic on all sides"
        )
    if scene.layers is not None:
        periodic = (*periodic[:2], False)
    return x, radius, box, periodic


def _frame(scene: p.ParticleScene, frames: list[dumps.Frame]) -> dumps.Frame:
    assert scene.particles is not None
    if scene.particles.step is None:
        return frames[-1]
    for frame in frames:
        if frame.step == scene.particles.step:
            return frame
    steps = ", ".join(str(frame.step) for frame in frames)
    where = scene.origin.at(("particles", "step"))
    raise SceneError(f"{where}: particles.step = {scene.particles.step}: not in the dump; it has {steps}")


def _porosity(scene: p.ParticleScene, x: Array, radius: Array, box: tuple[Array, Array]) -> float:
    """Share of the volume without particles: of the periodic box, or between the two layers, spheres cut by planes."""
    if scene.layers is None:
        return float(1.0 - (4.0 / 3.0 * np.pi * radius**3).sum() / np.prod(box[1] - box[0]))
    low, high, area = scene.layers.bottom, scene.layers.top, scene.layers.area
    # volume of a sphere below a plane at height h above its centre: pi (2 R^3/3 + R^2 h - h^3/3)
    below = []
    for plane in (low, high):
        h = np.clip(plane - x[:, 2], -radius, radius)
        below.append(np.pi * (2.0 / 3.0 * radius**3 + radius**2 * h - h**3 / 3.0))
    return float(1.0 - (below[1] - below[0]).sum() / (area * (high - low)))
