"""Run of a two-fluid scene: rows over time, averages, checkpoints, files and
findings.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.errors import ContbedError, ConvergenceError, SceneError
from contbed.result import Result, beyond_ranges, timed
from contbed.scene.mesh import power_units
from contbed.two_fluid import files, of_fluidized, plausibility, probes
from contbed.two_fluid import plan as planning
from contbed.two_fluid import results as findings
from contbed.two_fluid import scene as t
from contbed.two_fluid.averages import Averages
from contbed.two_fluid.closures import HEAT_KINDS, known
from contbed.two_fluid.simulation import Simulation

if TYPE_CHECKING:
    from contbed.output.checkpoint import Keeper

# of the cells with particles, below which a closure of heat out of its range is left to
# the table of closures
FEW_CELLS = 0.01
RESTART_MAY_CHANGE = (
    "time.end",
    "time.sample",
    "time.checkpoint_every",
    "output.plots",
    "output.fields",
    "output.window",
    "output.levels",
)


class Run:
    """A bed on its way: rows over time and averages."""

    def __init__(self, plan: planning.TwoFluidPlan):
        self.plan, self.scene = plan, plan.scene
        self.bed, self.compiled = plan.bed()
        self.closures = {
            kind: closure
            for kind, closure in self.compiled.bound.items()
            if closure is not None
        }
        time = self.scene.time
        self.contents_at_start = findings.contents(self.bed)
        inlets = (getattr(part, "until", None) for part in self.scene.boundary.values())
        self.ends = sorted({end for end in inlets if end is not None})
        self.ended = 0
        self.averages = None
        if time.average_from is not None:
            self.averages = plan.place.averages(self.bed, time.average_from, time.end)
        self.bubbles = None
        if of_fluidized.has_bubbles(self.scene, self.bed.model.grid.dimension):
            from contbed.two_fluid.bubbles import Bubbles

            self.bubbles = Bubbles(plan)
        self.rows: list[list[float]] = []
        self.files: list[tuple[float, str]] = []
        self.interval = time.interval
        self.cut_steps = 0
        self.largest_speed = plausibility.largest_speed(self.scene, self.bed)
        self.take_row()

    def averaged(self) -> Averages | None:
        """Return the averages of the whole bed; None before there are any."""
        found = None if self.averages is None else self.averages.whole()
        return found if found is not None and found.weight.any() else None

    def take_row(self) -> None:
        """One row of profiles.csv."""
        self.rows.append(
            findings.row(self.bed) + probes.row(self.bed, self.plan.probes)
        )
        since = self.scene.time.average_from
        if self.bubbles is not None and self.bed.state.time >= (since or 0.0):
            self.bubbles.add(self.bed.state.time, self.bed.state.eps_s)
        given = known(self.bed, self.scene)
        for closure in self.closures.values():
            closure.record(**given)
        plausibility.require_possible(self.scene, self.bed, self.largest_speed)

    def end_pulses(self) -> bool:
        """Impose what follows the inlets whose time is over; whether there were any."""
        bed, ended = self.bed, sum(end <= self.bed.clock.time for end in self.ends)
        if ended == self.ended:
            return False
        self.ended = ended
        bed.impose(planning.conditions(self.scene, bed.model.grid, bed.clock.time))
        if bed.model.heat is not None:
            from contbed.two_fluid.heat import plan as heat_planning

            bed.impose_heat(
                heat_planning.thermal(
                    planning.parts(self.scene, bed.clock.time), self.scene
                )
            )
        return True

    def after_step(self, bed: Simulation) -> None:
        """Count steps that were cut, change inlets that have ended, and add the step
        to the averages.
        """
        self.cut_steps += bed.clock.dt_wanted < (self.scene.time.step or 0.0)
        if self.end_pulses():
            bed.find_fluxes(bed.clock.dt)
        if self.averages is not None:
            self.averages.add(bed)

    def arrays(self) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Arrays and numbers for a checkpoint."""
        state = self.bed.saved()
        plain = {
            name: value
            for name, value in state.items()
            if not isinstance(value, np.ndarray)
        }
        arrays = {
            name: value
            for name, value in state.items()
            if isinstance(value, np.ndarray)
        }
        arrays |= {
            "rows": np.array(self.rows),
            "counts": np.concatenate(self.compiled.counts),
            "contents_at_start": np.array(list(self.contents_at_start.values())),
        }
        arrays |= {
            f"ranges_{kind}": closure.state() for kind, closure in self.closures.items()
        }
        if self.averages is not None:
            arrays |= self.averages.whole().arrays()
        if self.bubbles is not None:
            arrays["bubbles"] = np.array(self.bubbles.found)
        meta = {
            "state": json.dumps(plain),
            "files": json.dumps(self.files),
            "interval": self.interval,
        }
        return arrays, meta

    def resume(self, arrays: Mapping[str, Any], meta: Mapping[str, Any]) -> None:
        """Resume from a checkpoint, bit for bit, with its interval of rows, which the
        steps meet, unless the scene gives one.

        Raises
        ------
        SceneError : it does not fit
        """
        from contbed.output.checkpoint import require_form

        require_form(arrays, self.arrays()[0], ("rows",))
        self.bed.restore({**arrays, **json.loads(meta["state"])})
        self.rows = np.asarray(arrays["rows"]).tolist()
        self.interval = self.scene.time.sample or meta["interval"]
        for count, saved in zip(self.compiled.counts, arrays["counts"], strict=True):
            count[0] = saved
        self.contents_at_start = dict(
            zip(
                self.contents_at_start,
                np.asarray(arrays["contents_at_start"]).tolist(),
                strict=True,
            )
        )
        self.files = [
            (float(time), str(name)) for time, name in json.loads(meta["files"])
        ]
        for kind, closure in self.closures.items():
            closure.restore(arrays[f"ranges_{kind}"])
        if self.bubbles is not None:
            self.bubbles.found = np.asarray(arrays["bubbles"]).tolist()
        if self.averages is not None:
            self.averages.resume(dict(arrays))
            self._require_same_window(meta["identity"]["values"]["time"]["end"])
        self.end_pulses()

    def _require_same_window(self, end: float) -> None:
        """Refuse another end of averages, whose halves are those of the window, once
        they have begun.
        """
        if (found := self.averaged()) is not None and end != self.scene.time.end:
            where = self.scene.origin.at(("time", "end"))
            text = (
                f"the averages since {found.start:g} s are of a window that ends at "
                f"{end:g} s"
            )
            raise SceneError(f"{where}: time.end = {self.scene.time.end:g}: {text}")


@timed("flow")
def run(
    plan: Any,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Mapping[str, Any], Any] | None,
) -> None:
    """Run and fill the result; fields and checkpoints go into `folder`."""
    from contbed.output.checkpoint import Keeper
    from contbed.output.progress import Progress
    from contbed.scene.identity import identity

    run = Run(plan)
    scene: t.TwoFluidScene = plan.scene
    keeper = Keeper(folder, identity(scene), scene.time.checkpoint_every)
    if start is not None:
        run.resume(*start)
    result.warnings += plan.warnings
    # outputs that cannot be evaluated are reported before the steps
    _raise_first(_rehearse(run))
    stops = (
        np.arange(1, max(1, round(scene.time.end / run.interval)) + 1) * run.interval
    )
    stops[-1] = scene.time.end
    failed: list[ContbedError] = []
    try:
        with keeper, Progress(scene.time.end, quiet=quiet) as progress:

            def after_each_step(bed: Simulation) -> None:
                run.after_step(bed)
                progress.advance_to(bed.clock.time, f"step {bed.clock.dt:.2g} s")

            for stop in stops[stops > run.bed.state.time * (1.0 + 1e-12)]:
                for time in (
                    *(end for end in run.ends if run.bed.state.time < end < stop),
                    stop,
                ):
                    _advance(run, time, after_each_step)
                run.take_row()
                if folder is not None:
                    _keep(run, folder, keeper)
    finally:
        failed = _fill(run, result)
        result.warnings += map(str, failed)
        if folder is not None and scene.output.fields:
            _fields(run, folder)
    _raise_first(failed)
    if run.cut_steps:
        where, step = scene.origin.at(("time", "step")), scene.time.step
        text = (
            f"{run.cut_steps} of {run.bed.state.steps} steps were shortened; "
            "particles would cross more than a cell"
        )
        result.warnings.append(f"{where}: time.step = {step:g} s: {text}")
    result.warnings += of_fluidized.judge(scene, result.profiles, result.qoi)
    result.warnings += of_fluidized.carried_out(scene, result.profiles)
    if run.bubbles is not None:
        result.warnings += run.bubbles.judge(scene, result.qoi, run.interval)
    result.warnings += plausibility.judge(
        scene, run.bed, result.profiles, run.largest_speed
    )


def _advance(
    run: Run, time: float, after_each_step: Callable[[Simulation], None]
) -> None:
    """Advance the bed to `time` [s].

    Raises
    ------
    ConvergenceError : a field is not finite, or too many iterations; of theta without
        guards it says what these do
    """
    try:
        # numbers too large are found at the end of the step, with their field and place
        with np.errstate(over="ignore", invalid="ignore"):
            run.bed.advance(time, after_each_step)
    except ConvergenceError as error:
        if run.scene.two_fluid.guards or np.isfinite(run.bed.state.theta).all():
            raise
        where = run.scene.origin.at(("two_fluid", "guards"))
        text = (
            "without them shear heats few particles too fast; set guards = true, or "
            "lower time.courant to 0.1"
        )
        raise ConvergenceError(
            f"{error}; {where}: two_fluid.guards = false: {text}"
        ) from error


def _rehearse(run: Run) -> list[ContbedError]:
    """Evaluate all that a run reports as if its present state were its last; return
    the errors of parts that fail.
    """
    trial, bed = copy(run), copy(run.bed)
    bed.state = replace(bed.state, dt=1.0, time=run.scene.time.end)
    trial.bed, trial.rows = (
        bed,
        [*run.rows, findings.row(bed) + probes.row(bed, run.plan.probes)],
    )
    if run.averages is not None:
        trial.averages = Averages(run.averages.start, run.averages.end)
        trial.averages.add(bed)
    return _fill(trial, Result(run.plan))


def _raise_first(failed: list[ContbedError]) -> None:
    if failed:
        raise failed[0]


def _keep(run: Run, folder: Path, keeper: Keeper) -> None:
    """After a row write fields when their time has come, then the checkpoint, which
    counts them.
    """
    every = run.scene.time.fields
    next_time = np.inf if every is None else (len(run.files) + 1) * every * (1.0 - 1e-9)
    if run.scene.output.fields and run.bed.state.time >= next_time:
        _fields(run, folder)
    keeper.offer(*run.arrays())


def _fields(run: Run, folder: Path) -> None:
    from contbed.output.vtu import write_series

    time = run.bed.clock.time
    if run.files and run.files[-1][0] == time:
        return
    path = folder / f"fields_{len(run.files):04d}.vtu"
    averages = None if run.averages is None else run.averages.whole()
    files.write(path, run.plan.mesh.skfem, run.bed, averages)
    run.files.append((time, path.name))
    write_series(folder / "fields.pvd", run.files)


def _fill(run: Run, result: Result) -> list[ContbedError]:
    """Fill in profiles, tables, balances, closures and named results; return the
    errors of parts that fail.
    """
    failed = []
    for name, part in _PARTS.items():
        try:
            part(run, result)
        except Exception as error:
            failed.append(
                ContbedError(
                    f"{name} cannot be evaluated: {type(error).__name__}: {error}"
                )
            )
            failed[-1].__cause__ = error
    return failed


def _fill_profiles(run: Run, result: Result) -> None:
    headers = [*findings.columns(run.bed), *probes.columns(run.bed, run.plan.probes)]
    result.profiles |= dict(zip(headers, np.array(run.rows).T.copy(), strict=True))


def _fill_balances(run: Run, result: Result) -> None:
    result.balances |= findings.balances(run.bed, run.contents_at_start)


def _fill_tables(run: Run, result: Result) -> None:
    result.tables |= findings.tables(run.plan, run.bed, run.averaged(), result.profiles)


def _fill_results(run: Run, result: Result) -> None:
    """Named results, counts, and the wall time of each phase of the steps."""
    bed = run.bed
    state = bed.state  # of ranks it is put together before counts are read
    result.timings |= {
        f"flow: {name}": seconds for name, seconds in bed.model.timer.seconds.items()
    }
    guarded = {name: count[0] for name, count in run.compiled.counts._asdict().items()}
    counts = {
        name: int(number)
        for name, number in (state.counters._asdict() | guarded).items()
        if number
    }
    found = findings.results(
        run.plan,
        bed,
        run.contents_at_start,
        run.averaged(),
        result.profiles,
        result.tables,
    )
    result.qoi |= found | counts | bed.traffic()
    result.units |= power_units(result.qoi, run.scene.mesh)


def _fill_bubbles(run: Run, result: Result) -> None:
    """Bubbles below the height of the bed, where there is one."""
    height = result.qoi.get("bed_height_m")
    if run.bubbles is None or height is None:
        return
    rows = result.profiles["t [s]"] >= run.scene.time.average_from
    found, table = run.bubbles.findings(int(rows.sum()), height)
    result.qoi |= found
    if table:
        result.tables["bubbles"] = table


def _fill_closures(run: Run, result: Result) -> None:
    used = {kind: closure.use().to_dict() for kind, closure in run.closures.items()}
    result.closures += used.values()
    of_heat = [use for kind, use in used.items() if kind in HEAT_KINDS.values()]
    result.warnings += beyond_ranges(of_heat, FEW_CELLS)


_PARTS = {
    "profiles": _fill_profiles,
    "balances": _fill_balances,
    "tables": _fill_tables,
    "named results": _fill_results,
    "bubbles": _fill_bubbles,
    "use of closures": _fill_closures,
}
