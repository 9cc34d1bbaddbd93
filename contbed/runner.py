"""Run one scene: plan, solve, verdict on balances and ranges, files. Whatever stops
a run, its last state is kept.
"""

from __future__ import annotations

import gc
import time as clock
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed import models
from contbed.compiled.threads import using
from contbed.engine import Elsewhere, Engine
from contbed.errors import (
    BalanceError,
    ClosureRangeError,
    ContbedError,
    ConvergenceError,
    SceneError,
    interrupt_in,
)
from contbed.fields import distinct, field, name_of
from contbed.result import Result, outside
from contbed.scene.identity import identity
from contbed.scene.inputs import all_inputs, inputs_by_key
from contbed.scene.mesh import per_extent
from contbed.scene.tables import SceneBase

if TYPE_CHECKING:
    from contbed.output.folder import RunFolder

STATUS = {
    ConvergenceError: "not converged",
    ClosureRangeError: "closure out of range",
    BalanceError: "balance open",
    KeyboardInterrupt: "interrupted",
    SceneError: "bad scene",
}
FAILED = "failed"  # by anything else
# units of amounts and flows, which on a line are per area, in a plane per depth
WHOLE = ("J", "W", "kg", "mol", "m3/s")


def run(
    scene: SceneBase,
    out: str | Path | None = None,
    quiet: bool = True,
    restart: str | Path | None = None,
    engine: str = "skfem",
    threads: int | None = None,
) -> Result:
    """Solve a scene.

    Parameters
    ----------
    scene : from `contbed.load`
    out : folder for the results; nothing is written, plotted or imported for it if None
    quiet : no progress bar
    restart : folder of an earlier run of the same scene whose checkpoint is continued
    engine : one of `engine_named`; under "dolfinx" only rank 0 returns a result, other
        ranks None
    threads : cores to compute on; None: all that may be used, where that is faster. The
        numbers do not depend on it

    Raises
    ------
    SceneError, ConvergenceError, ClosureRangeError, BalanceError : after what was found
        has been written to `out`
    ContbedError : a file cannot be written, after all others have been; another run is
        writing to `out`

    Examples
    --------
    >>> from contbed.loading import load
    >>> from contbed.models import MODELS
    >>> scene = load(MODELS["packed_bed"].template)
    >>> f"{run(scene).qoi['T_fluid_out_K']:.1f}"
    '911.4'
    """
    models.model_of(scene)
    with using(threads):
        chosen = engine_named(engine)
        return chosen.run(lambda: _run(scene, out, quiet, restart, chosen))


def engine_named(name: str) -> Engine:
    """Return what computes runs.

    Parameters
    ----------
    name : "skfem", this process; "dolfinx", several ranks by DOLFINx and PETSc;
        "lammps", which settles the packing of a scene of particles; "cuda", particles
        on a GPU
    """
    if name == "dolfinx":
        from contbed.ranks.engine import Ranks

        return Ranks()
    if name == "lammps":
        from contbed.dem.plan import on_lammps

        return Elsewhere(name, on_lammps)
    if name == "cuda":
        from contbed.dem.gpu import on_gpu

        return Elsewhere(name, on_gpu)
    return Engine()


def _run(
    scene: SceneBase,
    out: str | Path | None,
    quiet: bool,
    restart: str | Path | None,
    engine: Engine,
) -> Result:
    # before it is made for the results
    if restart is not None and not Path(restart).is_dir():
        from contbed.output.checkpoint import require_there

        require_there(restart)
    folder = (
        Path(out) if out is not None else Path(restart) if restart is not None else None
    )
    if folder is None:
        result, failure = _found(scene, None, quiet, restart, engine)
    else:
        from contbed.output.folder import occupied, require_inputs_elsewhere

        origin = scene.origin
        named = (
            (origin.place(path), file)
            for path, file in inputs_by_key(scene, origin.base)
        )
        require_inputs_elsewhere(folder, named)
        with occupied(folder) as place:
            result, failure = _found(scene, place, quiet, restart, engine)
    if failure is not None:
        raise failure
    return result


def _found(
    scene: SceneBase,
    place: RunFolder | None,
    quiet: bool,
    restart: str | Path | None,
    engine: Engine,
) -> tuple[Result, BaseException | None]:
    """Plan, solve and write; the result and what went wrong."""
    start = clock.perf_counter()
    goes_on = (
        place is not None
        and restart is not None
        and place.path.resolve() == Path(restart).resolve()
    )
    try:
        plan = engine.plan(scene)
        checkpoint = (
            None if restart is None else _checkpoint(scene, plan, Path(restart))
        )
    except Exception as error:
        if place is not None and not goes_on:
            place.mark_failed(_status(error), str(error))
        raise
    result = Result(plan, engine=engine)
    result.warnings += scene.warnings
    result.timings["plan"] = clock.perf_counter() - start
    if place is not None:
        about = {
            key: result.summary[key]
            for key in ("versions", "scene", "dofs", "built", "skipped")
        }
        place.begin(about, keep=goes_on, inputs=all_inputs(scene, scene.origin.base))
    failure = _solve(
        scene, result, place.path if place is not None else None, quiet, checkpoint
    )
    if place is not None and goes_on and isinstance(failure, SceneError):
        place.give_back()
        return result, failure
    result.timings["total"] = clock.perf_counter() - start
    result.usage = engine.usage()
    if place is not None:
        not_written = _write(result, place, failure)
        failure = failure or not_written
    return result, failure


def _clock(plan: Any, quiet: bool) -> AbstractContextManager[None]:
    """Return what shows the elapsed time of a run without steps; runs with steps
    have a bar of their own.
    """
    if quiet or plan.steps:
        return nullcontext()
    from contbed.output.progress import waiting

    return waiting()


@contextmanager
def _collecting_garbage() -> Iterator[None]:
    """Collect reference cycles for the block; the command line switches this off for
    its imports.
    """
    postponed = not gc.isenabled()
    if postponed and gc.get_freeze_count() == 0:
        gc.freeze()  # the imported modules have no garbage
    gc.enable()
    try:
        yield
    finally:
        if postponed:
            gc.disable()


def _solve(
    scene: SceneBase,
    result: Result,
    folder: Path | None,
    quiet: bool,
    checkpoint: tuple[Any, Any] | None,
) -> BaseException | None:
    """Fill the result; what stopped the run is returned, and stands in the result."""
    try:
        solve = models.solver_of(scene)
        with _collecting_garbage(), _clock(result.plan, quiet):
            solve(result.plan, result, folder, quiet, checkpoint)
        _verdict(scene, result)
    except (Exception, KeyboardInterrupt) as caught:
        error = interrupt_in(caught) or caught
        result.status = _status(error)
        if isinstance(error, ConvergenceError):
            result.history = error.history
            result.warnings.append(str(error))
            _keep_last(scene, error, folder)
        elif result.status == FAILED:
            name = (
                "" if isinstance(error, ContbedError) else f"{type(error).__name__}: "
            )
            result.warnings.append(f"{name}{error}")
        if checkpoint is None or result.status != FAILED:
            return error
        return _unlike(error)
    finally:
        _relate_balances(scene, result)
    return None


def _relate_balances(scene: SceneBase, result: Result) -> None:
    """Let balances of a bed on a line or in a plane be per area or depth, as its named
    results are.
    """
    mesh: Any = getattr(scene, "mesh", None)
    if not hasattr(mesh, "dimension"):
        return
    for balance in result.balances.values():
        if balance["unit"] in WHOLE:
            balance["unit"] = per_extent(balance["unit"], mesh)


def _unlike(error: BaseException) -> BaseException:
    """Return what to say of an error of a run that resumes: content of a checkpoint
    that no run has written leads to errors of all kinds.
    """
    if isinstance(error, ContbedError | OSError | MemoryError):
        return error
    text = f"the checkpoint does not fit this scene ({type(error).__name__}: {error})"
    found = SceneError(f"{' '.join(text.split())}; run without --restart")
    found.__cause__ = error
    return found


def _status(error: BaseException) -> str:
    return next(
        (text for kind, text in STATUS.items() if isinstance(error, kind)), FAILED
    )


def _write(
    result: Result, place: RunFolder, failure: BaseException | None
) -> BaseException | None:
    """Write all that can be written, the summary last; returns what could not."""
    interrupt: BaseException | None = None
    failed: list[ContbedError] = []
    try:
        with result.timed("output"):
            failed = result.write(place.path)
    except KeyboardInterrupt as error:
        interrupt = error
    if failure is None and (failed or interrupt):
        result.status = (
            "output incomplete" if interrupt is None else STATUS[KeyboardInterrupt]
        )
    result.warnings += [str(error) for error in failed]
    try:
        place.end(result.summary)
    except ContbedError as error:
        failed.append(error)
    if interrupt is not None or not failed:
        return interrupt
    texts = list(dict.fromkeys(str(error) for error in failed))
    if len(texts) == 1:
        return failed[0]
    every = ContbedError("\n".join(texts))
    # distinguishes a full disk from a fault of the scene
    every.__cause__ = failed[0].__cause__
    return every


def _verdict(scene: Any, result: Result) -> None:
    """Turn temperatures below 0 K, an open balance, or in strict mode a closure out
    of its range, into an error.
    """
    _require_temperatures(result)
    for name, balance in result.balances.items():
        if not abs(balance["relative_residual"]) <= scene.solver.balance_tolerance:
            left, allowed = distinct(
                balance["relative_residual"], scene.solver.balance_tolerance
            )
            raise BalanceError(
                f"balance of {name} is open by {left} of its largest part, allowed "
                f"{allowed}; lower solver.newton_tolerance "
                "or raise solver.balance_tolerance"
            )
    beyond = [closure for closure in result.closures if closure["share_outside"] > 0]
    if scene.solver.strict and beyond:
        raise ClosureRangeError("; ".join(outside(closure) for closure in beyond))


def _require_temperatures(result: Result) -> None:
    """Raise ConvergenceError where a temperature of profiles or tables is not above
    0 K.
    """
    for header, column in chain(
        result.profiles.items(), *(table.items() for table in result.tables.values())
    ):
        name = name_of(header)
        quantity = field(name)
        if quantity is None or quantity.unit != "K":
            continue
        known = np.asarray(column, dtype=float)
        # absent phases have no temperature
        coldest = float(np.min(known[~np.isnan(known)], initial=np.inf))
        if coldest <= quantity.lower:
            raise ConvergenceError(
                f"{name} falls to {coldest:.4g} K: a source, a flux or a wall takes "
                "more heat than the bed holds; "
                "this is no steady or reachable state"
            )


def _checkpoint(scene: SceneBase, plan: Any, folder: Path) -> tuple[Any, Any]:
    """Arrays and numbers of an earlier run of the same scene."""
    from contbed.output import checkpoint

    if not plan.steps:
        why = (
            "the scene takes no time steps"
            if getattr(scene, "time", None) is None
            else "its runs keep no checkpoint"
        )
        raise SceneError(
            f"{scene.origin.name}: nothing to restart, {why}; leave out --restart"
        )
    arrays, meta = checkpoint.load(folder)
    origin, may_change = (
        scene.origin,
        models.model_of(scene).find("run", "RESTART_MAY_CHANGE"),
    )
    checkpoint.require_same(
        meta, identity(scene), may_change, lambda key: origin.at(tuple(key.split(".")))
    )
    return arrays, meta


def _keep_last(scene: Any, error: ConvergenceError, folder: Path | None) -> None:
    """Keep the last Newton state of a steady run beside the summary."""
    if folder is None or scene.time is not None:
        return
    if not isinstance(error.state, np.ndarray):
        return
    from contbed.output import checkpoint

    checkpoint.save(folder, {"state": error.state}, {"identity": identity(scene)})
