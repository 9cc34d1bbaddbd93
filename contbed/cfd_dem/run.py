"""Run of a scene of particles in a gas: the bed, its march from sample to sample,
checkpoint and closure file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.arrays import Array
from contbed.cfd_dem.closures import bound
from contbed.cfd_dem.conduction import Solid
from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.heat_transfer import Average, bed_nusselt
from contbed.cfd_dem.history import History
from contbed.cfd_dem.levels import Levels
from contbed.cfd_dem.plan import GasPlan, settled, simulation_of
from contbed.cfd_dem.probes import probes_of
from contbed.cfd_dem.results import fill
from contbed.cfd_dem.scene import GasScene
from contbed.cfd_dem.tubes import TubeAverage, TubeHeat
from contbed.dem import extract
from contbed.dem.simulation import LISTS
from contbed.materials.constants import fluid_of
from contbed.output.progress import Progress
from contbed.result import Result, timed
from contbed.scene.moments import ROUNDING

if TYPE_CHECKING:
    from contbed.output.checkpoint import Keeper

RESTART_MAY_CHANGE = (
    "time.end",
    "time.checkpoint_every",
    "output.plots",
    "output.fields",
)


# arrays of a checkpoint that are longer later in a run
GROWS = ("rows", "file_times", "Re", "eps", *(f"particles_{name}" for name in LISTS))


@timed("particles and gas")
def run(
    plan: GasPlan,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Mapping[str, Any], Any] | None,
) -> None:
    """Run the plan and fill the result.

    Parameters
    ----------
    plan : from `cfd_dem.plan.plan`
    result : takes profiles, named results, balances and closure ranges, also of a run
        that is cut off
    folder : for particles, checkpoint and closure file; None: nothing is written
    quiet : no progress bar
    start : arrays of a checkpoint to continue from, or None

    Raises
    ------
    ConvergenceError : the particles or the gas fail
    """
    from contbed.output.checkpoint import Keeper, require_form
    from contbed.scene.identity import identity

    scene = plan.scene
    with result.timed("packing"):
        result.plan = plan = settled(plan, quiet, None if start is None else start[0])
    bed, solid = build(plan)
    history = History(
        Average(solid, scene.solid.emissivity, scene.inlet.temperature),
        probes_of(plan.grid, scene.output.probes),
        Levels(plan.grid, scene.output.levels),
        tuple(TubeAverage(tube) for tube in bed.tubes),
    )
    if start is not None:
        own = bed.state() | history.state()
        require_form(start[0], own, GROWS)
        bed.restore(start[0])
        history.restore(start[0])
    files = folder if scene.output.fields else None
    with Keeper(folder, identity(scene), scene.time.checkpoint_every) as keeper:
        try:
            _march(
                scene,
                bed,
                history,
                quiet,
                partial(_save, scene, bed, history, folder, keeper),
            )
        finally:
            fill(result, plan, bed, history)
            if files is not None:
                history.write_particles(files, bed)
        if folder is not None:
            keeper.offer(bed.state() | history.state())
    if scene.particles.closure is not None:
        _fit_closure(plan, result, folder)


def build(plan: GasPlan) -> tuple[Bed, Solid]:
    """Build the bed of a plan whose particles have settled, with its inlet open, and
    how its particles conduct.
    """
    scene = plan.scene
    assert plan.particles is not None
    table, grains = scene.particles, scene.solid
    simulation = simulation_of(table, grains, plan.particles, plan.engine, plan.tubes)
    solid = Solid(
        grains.conductivity,
        grains.heat_capacity,
        grains.youngs_modulus,
        table.exponents,
    )
    T = scene.T_start
    closures = bound(scene)
    flow = Gas(
        plan.grid,
        fluid_of(scene.gas, scene.origin),
        closures["drag"],
        closures.get("nusselt"),
        T or scene.inlet.temperature,
        T is None,
        simulation.gravity,
        scene.boundary.sides.gas.wall == "no_slip",
        tolerance=scene.solver.pressure_tolerance,
    )
    heat: dict[str, Any] = (
        {} if scene.heat is None else {"T": T, "heat_interval": scene.heat.interval}
    )
    bed = Bed(
        simulation,
        flow,
        scene.time.step,
        heat_capacity=grains.heat_capacity,
        solid=solid,
        emissivity=grains.emissivity,
        moving=not table.fixed,
        tubes=[TubeHeat(tube, plan.grid, solid) for tube in plan.tubes],
        **heat,
    )
    _open_inlet(scene, bed)
    return bed, solid


def _open_inlet(scene: GasScene, bed: Bed) -> None:
    """Set the inlet as it is at the time of the bed: with the jet until it ends."""
    inlet, jet = scene.inlet, scene.boundary.jet
    until = None if jet is None else jet.until
    ended = until is not None and bed.time >= until * (1.0 - ROUNDING)
    if jet is None or ended:
        bed.gas.inlet(inlet.velocity, inlet.temperature)
        return
    T, slot, speed = scene.T_jet, (jet.start, jet.end), jet.gas.velocity
    if jet.gas.mass_flux is not None:
        speed = jet.gas.mass_flux / float(bed.gas.fluid.density(T))
    assert speed is not None  # `checks` sees to it
    bed.gas.inlet(inlet.velocity, inlet.temperature, slot, speed, T)


def _march(
    scene: GasScene, bed: Bed, history: History, quiet: bool, save: Callable[[], None]
) -> None:
    """Advance from stop to stop; average, record and save at each."""
    time = scene.time
    with Progress(time.end, "s", quiet) as progress:
        for stop in _stops(scene):
            if stop <= bed.time * (1.0 + ROUNDING):
                continue
            bed.run(stop - bed.time, reached=progress.advance_to)
            _open_inlet(scene, bed)
            if bed.time >= time.average_from * (1.0 - ROUNDING):
                history.take(bed)
            history.record(bed)
            save()


def _stops(scene: GasScene) -> Array:
    """Return the times of samples, of the end of the jet and of the run [s]."""
    time, jet = scene.time, scene.boundary.jet
    count = ceil(time.end / time.sample * (1.0 - ROUNDING))
    stops: Array = np.arange(1.0, count + 1.0) * time.sample
    if stops[-1] > time.end * (1.0 + ROUNDING):
        stops[-1] = time.end
    if jet is not None and jet.until is not None and jet.until < time.end:
        stops = np.sort(np.append(stops, jet.until))
    return stops


def _save(
    scene: GasScene, bed: Bed, history: History, folder: Path | None, keeper: Keeper
) -> None:
    """Write the particles if their time has come, then the checkpoint, which counts
    them.
    """
    if folder is None:
        return
    every = scene.time.fields
    due = every is not None and bed.time >= (len(history.file_times) + 1) * every * (
        1.0 - 1e-9
    )
    if scene.output.fields and due:
        history.write_particles(folder, bed)
    keeper.offer(bed.state() | history.state())


def _fit_closure(plan: GasPlan, result: Result, folder: Path | None) -> None:
    """Fit Nu over Re to bed averages of a fixed bed at several velocities and write
    closure.toml.
    """
    from contbed.scene.identity import scene_hash

    scene = plan.scene
    table = scene.particles.closure
    assert table is not None
    points = []
    for velocity in table.velocities:
        bed, solid = build(plan)
        points.append(
            bed_nusselt(bed, velocity, scene.inlet.temperature, solid, table.of)
        )
    fit = extract.fit_power(*np.array(points).T)
    result.qoi["closure_residual"] = fit.content["residuals"]["largest"]
    if folder is not None:
        name = Path(scene.origin.name).name
        fit.write(
            folder / "closure.toml",
            {"scene": name, "scene_hash": scene_hash(scene), "of": table.of},
        )
