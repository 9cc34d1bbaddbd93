"""Plan and run of a scene of particles in a gas: coefficients by mechanism, balances, profiles over time, closure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.balance import Balance
from contbed.cfd_dem import scene as g
from contbed.cfd_dem.closures import bound
from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.grid import Grid
from contbed.cfd_dem.heat_transfer import Average, Solid, bed_nusselt
from contbed.dem import dumps, extract
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.statistics import surface
from contbed.dem.walls import INFINITE, Domain, box
from contbed.errors import SceneError
from contbed.fields import header
from contbed.models import described
from contbed.result import Result, timed
from contbed.scene.tables import FluidConstant

Array = NDArray[np.float64]

SPREAD = (5, 50, 95)  # percentiles of the coefficients that are reported
_COLUMNS = ("t", "pressure_drop", "height", "coordination")


@dataclass(frozen=True)
class GasPlan:
    """What a run builds: the particles at the start and the grid of the gas."""

    scene: g.GasScene
    particles: Particles
    grid: Grid
    domain: Domain
    built: tuple[tuple[str, str], ...]
    skipped: tuple[tuple[str, str], ...]
    mesh: None = None
    without_weak_form: str = "scenes of kind particles_gas"
    steps: bool = True

    @property
    def policy(self) -> Any:
        """How linear systems are solved."""
        from contbed.solvers.linear import Policy

        return Policy(3, None)

    def unknowns(self) -> dict[str, int]:
        """Number of unknowns: coordinates of particles, velocities and pressures of the gas, temperatures."""
        moving = 0 if self.scene.particles.fixed else 6 * len(self.particles)
        heat = len(self.particles) + self.grid.cells if self.scene.heat is not None else 0
        return {"particles": moving, "gas": int(self.grid.active.sum()) + self.grid.cells, "heat": heat}

    def __str__(self) -> str:
        return described(self)


def plan(scene: g.GasScene) -> GasPlan:
    """Settle or read the particles and lay the grid."""
    table = scene.particles
    sides = (table.periodic, table.periodic)
    domain = Domain((0.0, 0.0, 0.0), (*table.width, INFINITE), (*sides, False))
    particles = _read(scene) if table.file is not None else _settled(scene)
    _require_room(scene, particles)
    d = 2.0 * float(particles.radius.max())
    wide, high = (scale * d for scale in scene.gas.cell)
    count = tuple(
        max(1, round(length / size))
        for length, size in zip((*table.width, scene.gas.height), (wide, wide, high), strict=True)
    )
    grid = Grid(np.zeros(3), np.array([*table.width, scene.gas.height]) / count, count, sides)  # type: ignore[arg-type]
    built = [
        ("particles", f"{len(particles)}, {'fixed' if table.fixed else 'moving'}"),
        ("gas", " x ".join(str(n) for n in count) + " cells"),
    ]
    skipped: list[tuple[str, str]] = []
    for there, what, how, why in (
        (scene.heat is not None, "energy", "gas and particles", "no [heat] table: one temperature"),
        (table.emissivity > 0.0, "radiation", "to the neighbours", "particles.emissivity is 0"),
        (scene.closure is not None, "closure file", "power of Re", "no [closure] table"),
    ):
        (built if there else skipped).append((what, how if there else why))
    return GasPlan(scene, particles, grid, domain, tuple(built), tuple(skipped))


@dataclass
class History:
    """Rows of profiles.csv and averages, which a checkpoint carries."""

    average: Average
    rows: list[list[float]] = field(default_factory=list)
    names: tuple[str, ...] = ()


@timed("particles and gas")
def run(
    plan: Any, result: Result, folder: Path | None, quiet: bool, start: tuple[Mapping[str, Any], Any] | None
) -> None:
    """Run and fill the result; particles, checkpoint and a closure file go into `folder`."""
    scene: g.GasScene = plan.scene
    bed, solid = build(plan)
    history = History(Average(solid, scene.particles.emissivity, scene.gas.T))
    if start is not None:
        _resume(bed, history, start[0])
    files: list[tuple[float, str]] = []
    keep = _keeper(scene, bed, history, folder, files)
    try:
        _run(scene, bed, history, quiet, keep)
    finally:
        _findings(plan, bed, history, result)
        if folder is not None and scene.output.fields:
            _particle_file(folder, bed, files)
    if scene.closure is not None:
        _closure(plan, result, folder)


def build(plan: GasPlan) -> tuple[Bed, Solid]:
    """The bed of a plan, with its inlet open, and how its particles conduct."""
    scene = plan.scene
    table, gas = scene.particles, scene.gas
    material = _material(table)
    simulation = Simulation(
        plan.particles,
        [material],
        box(plan.domain),
        plan.domain,
        impact_speed=0.3,
        gravity=(0.0, 0.0, -9.81 if gas.gravity else 0.0),
    )
    solid = Solid(table.conductivity, table.heat_capacity, table.modulus_real, table.exponents)
    T = None if scene.heat is None else scene.heat.T
    closures = bound(scene)
    flow = Gas(
        plan.grid,
        _fluid(scene),
        closures["drag"],
        closures["nusselt"],
        T or gas.T,
        T is None,
        simulation.gravity,
        gas.no_slip,
        tolerance=scene.solver.pressure_tolerance,
    )
    interval = 5e-3 if scene.heat is None else scene.heat.interval
    bed = Bed(simulation, flow, gas.step, T, table.heat_capacity, solid, table.emissivity, interval, not table.fixed)
    _open(scene, bed)
    return bed, solid


def _open(scene: g.GasScene, bed: Bed) -> None:
    """The inlet as it is at the time of the bed."""
    gas, jet = scene.gas, scene.gas.jet
    if jet is None or (jet.end is not None and bed.time >= jet.end * (1.0 - 1e-9)):
        bed.gas.inlet(gas.velocity, gas.T)
        return
    speed = jet.mass_flux / float(bed.gas.fluid.density(jet.T))
    bed.gas.inlet(gas.velocity, gas.T, jet.slot, speed, jet.T)


def _run(scene: g.GasScene, bed: Bed, history: History, quiet: bool, keep: Callable[[], None]) -> None:
    time = scene.time
    stops = np.arange(1, round(time.end / time.sample) + 1) * time.sample
    if scene.gas.jet is not None and scene.gas.jet.end is not None:
        stops = np.union1d(stops, scene.gas.jet.end)
    for stop in stops[stops > bed.time * (1.0 + 1e-9)]:
        bed.run(stop - bed.time, quiet=quiet)
        _open(scene, bed)
        if bed.time >= time.average_from * (1.0 - 1e-9):
            history.average(bed)
        _row(bed, history)
        keep()


def _row(bed: Bed, history: History) -> None:
    simulation = bed.simulation
    contacts = 2.0 * len(simulation.contacts()) / len(simulation.position)
    row = [bed.time, bed.gas.pressure_drop, surface(simulation.position, simulation.radius), contacts]
    names = [header(name) for name in _COLUMNS]
    if bed.T is not None:
        held = bed.gas.mass.sum()
        row += [float(bed.gas.mass @ bed.gas.T / held), float(bed.T.mean())]
        names += [header("T_fluid"), header("T_solid")]
    history.rows.append(row)
    history.names = tuple(names)


def _findings(plan: GasPlan, bed: Bed, history: History, result: Result) -> None:
    scene, average = plan.scene, history.average
    if history.rows:
        result.profiles |= dict(zip(history.names, np.array(history.rows).T.copy(), strict=True))
    result.balances["gas"] = _balance(bed.mass_balance(), "kg", float(bed.gas.mass.sum()))
    if heat := bed.balance():
        result.balances["energy"] = _balance(heat, "J", abs(bed.gas.sums["gained"]))
        result.qoi |= {"T_solid_mean_K": float(bed.T.mean()), "T_fluid_max_K": float(bed.gas.T.max())}  # type: ignore[union-attr]
        result.qoi["radiation_not_balanced [J]"] = bed.radiated
    weight = float(bed.simulation.mass.sum()) * 9.81 / float(np.prod(scene.particles.width))
    result.qoi |= {
        "time [s]": bed.time,
        "bed_weight [Pa]": weight,
        "above_grid": bed.above,
        "porosities_raised": bed.gas.counts["raised"],
    }
    for what, number in (
        ("particles above the grid of the gas", bed.above),
        ("porosities below 0.2, raised", bed.gas.counts["raised"]),
    ):
        if number:
            result.warnings.append(f"{number} times {what}")
    if not average.count:
        return
    total = average.total
    result.qoi |= {f"h_{name} [W/m2/K]": value for name, value in average.bed_means().items()}
    result.qoi |= {
        "h_total [W/m2/K]": float(total.mean()),
        "coordination": average.coordination,
        "porosity": float(average.eps.mean()),
        "samples": average.count,
    }
    conduction = total - average.mean["convection"] - average.mean.get("radiation", 0.0)
    for name, values in (("convection", average.mean["convection"]), ("conduction", conduction), ("total", total)):
        result.qoi[f"h_{name}_percentiles [W/m2/K]"] = np.percentile(values, SPREAD).tolist()
    rows = np.array(history.rows)
    late = rows[:, 0] >= scene.time.average_from * (1.0 - 1e-9)
    result.qoi |= {"pressure_drop [Pa]": float(rows[late, 1].mean()), "height [m]": float(rows[late, 2].mean())}
    closures = bound(scene)
    around = {"Re": average.Re, "Pr": average.Pr, "eps": average.eps}
    d_p, mu = 2.0 * plan.particles.radius, float(np.mean(bed.gas.fluid.viscosity(bed.gas.T)))
    for kind, known in (("drag", around | {"d_p": d_p, "mu": mu}), ("nusselt", around)):
        result.closures.append(closures[kind].use(**known).to_dict())


def _balance(parts: Mapping[str, float], unit: str, floor: float) -> dict[str, Any]:
    """Balance of the parts in, out, source and stored, against the largest of them and `floor`."""
    return Balance(parts["in"], parts["out"], unit, parts["source"], parts["stored"], floor=floor).as_dict()


def _closure(plan: GasPlan, result: Result, folder: Path | None) -> None:
    """Bed averages of Nu over Re of a fixed bed at several velocities, fitted."""
    from contbed.scene.identity import scene_hash

    scene = plan.scene
    assert scene.closure is not None
    points = []
    for U in scene.closure.velocities:
        bed, solid = build(plan)
        points.append(bed_nusselt(bed, U, scene.gas.T, solid, scene.closure.of))
    fit = extract.fit_power(*np.array(points).T)
    result.qoi["closure_residual"] = fit.content["residuals"]["largest"]
    if folder is not None:
        name = Path(scene.origin.name).name
        fit.write(folder / "closure.toml", {"scene": name, "scene_hash": scene_hash(scene), "of": scene.closure.of})


def _keeper(
    scene: g.GasScene, bed: Bed, history: History, folder: Path | None, files: list[tuple[float, str]]
) -> Callable[[], None]:
    """What writes the checkpoint after a sample, and the particles when their time has come."""
    from contbed.output import checkpoint
    from contbed.scene.identity import scene_hash

    label = scene_hash(scene)

    def keep() -> None:
        if folder is None:
            return
        checkpoint.save(folder, bed.state() | _packed(history), {"scene_hash": label})
        every = scene.time.fields
        if scene.output.fields and every is not None and bed.time >= (len(files) + 1) * every * (1.0 - 1e-9):
            _particle_file(folder, bed, files)

    return keep


def _particle_file(folder: Path, bed: Bed, files: list[tuple[float, str]]) -> None:
    from contbed.dem.plots import write_particles
    from contbed.output.vtu import write_series

    simulation = bed.simulation
    columns = {"radius": simulation.radius, "velocity": simulation.velocity, "force": bed.force}
    if bed.T is not None:
        columns["T_solid"] = bed.T
    name = f"particles_{len(files):04d}.vtu"
    write_particles(folder / name, simulation.position, columns)
    files.append((bed.time, name))
    write_series(folder / "particles.pvd", files)


def _packed(history: History) -> dict[str, Array]:
    average = history.average
    arrays = {f"mean_{name}": value for name, value in average.mean.items()}
    numbers = np.array([average.count, average.coordination, average.Pr])
    return arrays | {"rows": np.array(history.rows), "numbers": numbers, "Re": average.Re, "eps": average.eps}


def _resume(bed: Bed, history: History, arrays: Mapping[str, Any]) -> None:
    bed.restore(arrays)
    average = history.average
    history.rows = arrays["rows"].tolist()
    count, average.coordination, average.Pr = arrays["numbers"].tolist()
    average.count, average.Re, average.eps = int(count), arrays["Re"], arrays["eps"]
    average.mean = {name[5:]: value for name, value in arrays.items() if name.startswith("mean_")}


def _fluid(scene: g.GasScene) -> Any:
    table = scene.fluid
    if isinstance(table, FluidConstant):
        from contbed.materials.constant import ConstantFluid

        assert table.heat_capacity is not None and table.conductivity is not None
        return ConstantFluid(table.density, table.heat_capacity, table.viscosity, table.conductivity)
    from contbed.materials.gas import gas_mixture

    return gas_mixture(table.composition, table.pressure, table.mechanism)


def _material(table: g.GasParticles) -> Material:
    return Material(
        table.density,
        table.modulus,
        table.poisson_ratio,
        table.restitution,
        table.sliding_friction,
        table.rolling_friction,
    )


def _settled(scene: g.GasScene) -> Particles:
    table = scene.particles
    assert table.radius is not None
    material = _material(table)
    packing = pack(
        table.width,
        radius=table.radius,
        count=table.count,
        seed=table.seed,
        material=material,
        periodic=(table.periodic, table.periodic),
    )
    return Particles(packing.position, packing.radius)


def _read(scene: g.GasScene) -> Particles:
    table = scene.particles
    assert table.file is not None
    path = scene.origin.base / table.file
    if not dumps.is_dump(path):
        return Particles(dumps.read_positions(path), table.radius or 0.0)
    frame = dumps.read_dump(path)[-1]
    speeds = [frame.columns.get(name) for name in ("vx", "vy", "vz")]
    v = 0.0 if table.fixed or any(speed is None for speed in speeds) else np.stack(speeds, axis=1)  # type: ignore[arg-type]
    radius = frame.radius if table.radius is None else np.full(len(frame.x), table.radius)
    return Particles(frame.x - frame.low, radius, velocity=v)


def _require_room(scene: g.GasScene, particles: Particles) -> None:
    """Refuse particles whose centres are outside of the box."""
    room = (*scene.particles.width, scene.gas.height)
    for axis, key in enumerate(("particles.width", "particles.width", "gas.height")):
        far = particles.position[:, axis]
        if far.min() < 0.0 or far.max() > room[axis]:
            where = scene.origin.at(tuple(key.split(".")))
            raise SceneError(
                f"{where}: {key}: centres from {far.min():.4g} to {far.max():.4g} m in {'xyz'[axis]}, "
                f"the box from 0 to {room[axis]:.4g} m"
            )
