"""Run one scene: plan, solve, verdict on balances and ranges, files. Whatever stops a run, its last state is kept."""

from __future__ import annotations

import time as clock
from pathlib import Path
from typing import Any

import numpy as np

from contbed import models
from contbed.errors import BalanceError, ClosureRangeError, ConvergenceError, SceneError
from contbed.result import Result, outside
from contbed.scene.identity import scene_hash
from contbed.scene.tables import SceneBase

STATUS = {
    ConvergenceError: "not converged",
    ClosureRangeError: "closure out of range",
    BalanceError: "balance open",
    KeyboardInterrupt: "interrupted",
}


def run(
    scene: SceneBase,
    out: str | Path | None = None,
    quiet: bool = True,
    restart: str | Path | None = None,
    engine: str = "skfem",
) -> Result:
    """Solve a scene.

    Parameters
    ----------
    scene : from `contbed.load`
    out : folder for the results; nothing is written, plotted or imported for it if None
    quiet : no progress bar
    restart : folder of an earlier run of the same scene whose checkpoint is continued
    engine : "skfem", or "dolfinx" for PETSc under MPI; then only the first rank returns a result, others None

    Raises
    ------
    SceneError, ConvergenceError, ClosureRangeError, BalanceError : after what was found has been written to `out`
    """
    if engine != "skfem":
        from contbed.fem.ranks import run_on_root

        return run_on_root(lambda: _run(scene, out, quiet, restart, engine))
    return _run(scene, out, quiet, restart, engine)


def _run(scene: SceneBase, out: str | Path | None, quiet: bool, restart: str | Path | None, engine: str) -> Result:
    start = clock.perf_counter()
    folder = Path(out) if out is not None else Path(restart) if restart is not None else None
    plan: Any = models.plan(scene)
    if engine != "skfem":
        from contbed.fem.dolfinx import on_dolfinx

        plan = on_dolfinx(plan)
    result = Result(plan)
    result.timings["plan"] = clock.perf_counter() - start
    checkpoint = None if restart is None else _checkpoint(scene, plan, Path(restart))
    if folder is not None:
        from contbed.output.files import prepare

        prepare(folder)
    failure: BaseException | None = None
    try:
        models.model_of(scene).find("run", "run")(plan, result, folder, quiet, checkpoint)
        _verdict(scene, result)
    except (ConvergenceError, ClosureRangeError, BalanceError, KeyboardInterrupt) as error:
        failure, result.status = error, STATUS[type(error)]
        if isinstance(error, ConvergenceError):
            result.history = error.history
            result.warnings.append(str(error))
            _keep_last(scene, error, folder)
    result.timings["total"] = clock.perf_counter() - start
    if engine != "skfem":
        from contbed.fem.dolfinx import engine_usage

        result.engine = engine_usage()
    if folder is not None:
        with result.timed("output"):
            result.write(folder)
    if failure is not None:
        raise failure
    return result


def _verdict(scene: Any, result: Result) -> None:
    """Turn an open balance, or in strict mode a closure out of its range, into an error."""
    for name, balance in result.balances.items():
        if not abs(balance["relative_residual"]) <= scene.solver.balance_tolerance:
            raise BalanceError(
                f"balance of {name} is open by {balance['relative_residual']:.2g} of its largest part, allowed "
                f"{scene.solver.balance_tolerance:.2g}; lower solver.newton_tolerance or raise solver.balance_tolerance"
            )
    beyond = [closure for closure in result.closures if closure["share_outside"] > 0]
    if scene.solver.strict and beyond:
        raise ClosureRangeError("; ".join(outside(closure) for closure in beyond))


def _checkpoint(scene: SceneBase, plan: Any, folder: Path) -> tuple[Any, Any]:
    """Arrays and numbers of an earlier run of the same scene."""
    from contbed.output import checkpoint

    if not plan.steps:
        raise SceneError(f"{scene.origin.name}: nothing to restart, the scene takes no time steps; leave out --restart")
    arrays, meta = checkpoint.load(folder)
    checkpoint.require_same(meta, scene_hash(scene))
    return arrays, meta


def _keep_last(scene: Any, error: ConvergenceError, folder: Path | None) -> None:
    """A steady run keeps its last Newton state beside the summary."""
    if folder is None or error.state is None or scene.time is not None:
        return
    from contbed.output import checkpoint

    checkpoint.save(folder, {"state": np.asarray(error.state)}, {"scene_hash": scene_hash(scene)})
