"""Run one scene: plan, flow, heat, results. Whatever stops a run, its last state is kept."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from contbed.errors import BalanceError, ClosureRangeError, ConvergenceError, SceneError
from contbed.models import KINDS, find
from contbed.packed_bed import scene as s
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.plan import plan as make_plan
from contbed.result import Result

NOTICED = 1e-2  # share of the heat above 0 K in streams and bed below which rounding of temperatures blurs a balance
STATUS = {
    ConvergenceError: "not converged",
    ClosureRangeError: "closure out of range",
    BalanceError: "balance open",
    KeyboardInterrupt: "interrupted",
}
OVERSHOOT = 1e-3  # share of the span of temperatures beyond which a warning is given


def run(
    scene: s.Scene,
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
        from contbed.fem.ranks import lead

        return lead(lambda: _run(scene, out, quiet, restart, engine))
    return _run(scene, out, quiet, restart, engine)


def _run(scene: s.Scene, out: str | Path | None, quiet: bool, restart: str | Path | None, engine: str) -> Result:
    start = clock.perf_counter()
    folder = Path(out) if out is not None else Path(restart) if restart is not None else None
    plan: Any = make_plan(scene)
    if engine != "skfem":
        from contbed.fem.dolfinx import adopted

        plan = adopted(plan)
    result = Result(plan)
    result.timings["plan"] = clock.perf_counter() - start
    checkpoint = None if restart is None else _checkpoint(scene, plan, Path(restart))
    if folder is not None:
        from contbed.output.files import prepare

        prepare(folder)
    failure: BaseException | None = None
    try:
        _solve(scene, plan, result, folder, quiet, checkpoint)
        _verdict(scene, result)
    except (ConvergenceError, ClosureRangeError, BalanceError, KeyboardInterrupt) as error:
        failure, result.status = error, STATUS[type(error)]
        if isinstance(error, ConvergenceError):
            result.history = error.history
            result.warnings.append(str(error))
            _keep_last(scene, error, folder)
    result.timings["total"] = clock.perf_counter() - start
    if engine != "skfem":
        from contbed.fem.dolfinx import account

        result.engine = account()
    if folder is not None:
        with _timed(result, "output"):
            result.write(folder)
    if failure is not None:
        raise failure
    return result


def _verdict(scene: s.Scene, result: Result) -> None:
    """Turn an open balance, or in strict mode a closure out of its range, into an error."""
    for name, balance in result.balances.items():
        if not abs(balance["relative_residual"]) <= scene.solver.balance_tolerance:
            raise BalanceError(
                f"balance of {name} is open by {balance['relative_residual']:.2g} of its largest part, allowed "
                f"{scene.solver.balance_tolerance:.2g}; lower solver.newton_tolerance or raise solver.balance_tolerance"
            )
    outside = [closure for closure in result.closures if closure["share_outside"] > 0]
    if scene.solver.strict and outside:
        raise ClosureRangeError("; ".join(_outside(closure) for closure in outside))


def _outside(closure: dict[str, Any]) -> str:
    parts = [
        f"{name} {use['used'][0]:.4g} to {use['used'][1]:.4g}, declared {use['declared'][0]} to {use['declared'][1]}"
        for name, use in closure["ranges"].items()
        if use["share_outside"] > 0
    ]
    return f"closure {closure['name']} is out of its range: {', '.join(parts)}"


@contextmanager
def _timed(result: Result, phase: str) -> Iterator[None]:
    start = clock.perf_counter()
    try:
        yield
    finally:
        result.timings[phase] = result.timings.get(phase, 0.0) + clock.perf_counter() - start


def _checkpoint(scene: s.Scene, plan: Plan, folder: Path) -> tuple[Any, Any]:
    """Arrays and numbers of an earlier run of the same scene."""
    from contbed.output import checkpoint
    from contbed.scene.loading import scene_hash

    if scene.time is None or plan.fronts:
        raise SceneError(f"{scene.origin.name}: nothing to restart, the scene takes no time steps; leave out --restart")
    arrays, meta = checkpoint.load(folder)
    checkpoint.require_same(meta, scene_hash(scene))
    return arrays, meta


def _solve(
    scene: s.Scene, plan: Plan, result: Result, folder: Path | None, quiet: bool, start: tuple[Any, Any] | None
) -> None:
    if scene.kind in KINDS:
        kind = KINDS[scene.kind]
        with _timed(result, kind.phase):
            find(kind.solve)(plan, result, folder, quiet, start)
        return
    if plan.fronts:
        with _timed(result, "heat"):
            _track_fronts(plan, result)
        return
    if scene.heat is None and scene.radiation is not None:
        _radiation(plan, result)
        return
    for attempt in range(plan.adaptations + 1):
        flow = None
        if not plan.plug:
            with _timed(result, "flow"):
                flow = _flow(plan, result)
        if scene.heat is None:
            return
        problem = _heat_problem(plan, flow, result)
        if scene.time is not None:
            _transient(scene, plan, problem, result, folder, quiet, start)
            return
        error = _steady(plan, problem, result, last=attempt == plan.adaptations)
        if error is None:
            return
        plan = result.plan = plan.refined(error)
        result.adaptations += 1


def _radiation(plan: Plan, result: Result) -> None:
    """A medium that radiates by itself."""
    from contbed.radiation.problem import emission
    from contbed.radiation.results import radiation_findings

    with _timed(result, "radiation"):
        problem = _radiation_problem(plan)
        state, history = problem.solve(plan.policy)
        result.history += history
    fluxes, conducted = problem.fluxes(state), problem.conducted(problem.assemble(state, False)[0])
    parts = {name: {"radiation": value} for name, value in fluxes.items()}
    result.balances["energy"] = _heat_balance(
        parts,
        conducted,
        problem.released(state),
        0.0,
        "W",
        emission(problem.optics, problem.surfaces, plan.mesh, plan.section),
    )
    radiation_findings(plan, problem, state, fluxes, conducted, result)


def _radiation_problem(plan: Plan) -> Any:
    from contbed.radiation.problem import RadiationProblem

    problem: Any = RadiationProblem
    level = plan.solved.radiation.level if plan.solved.radiation else ""
    if level == "ordinates":
        from contbed.radiation.ordinates import OrdinatesProblem as problem
    elif level == "rosseland":
        from contbed.radiation.rosseland import RosselandProblem as problem
    return problem(plan.solved, plan.mesh, plan.section)


def _heat_problem(plan: Plan, flow: Any, result: Result) -> Any:
    from contbed.packed_bed.heat import HeatProblem
    from contbed.packed_bed.heat_coefficients import Motion

    with _timed(result, "heat setup"):
        motion = Motion(plan.velocity, plan.velocity_solid, flow)
        problem = HeatProblem(plan.solved, plan.mesh, plan.medium, motion, plan.section)
    result.warnings += [text for text in problem.idle if text not in result.warnings]
    return problem


def _flow(plan: Plan, result: Result) -> Any:
    from contbed.packed_bed.flow import coefficients, solve_flow

    scene, options = plan.scene, plan.scene.solver
    c = coefficients(scene, plan.medium, plan.velocity, plan.velocity_solid)
    flow = solve_flow(
        plan.mesh,
        c,
        plan.velocity,
        plan.conditions,
        plan.policy,
        tolerance=options.newton_tolerance,
        iterations=options.newton_iterations,
    )
    result.history += flow.history
    outflow = {name: flow.outflow(name) for name in plan.mesh.boundaries}
    entering = -sum(v for v in outflow.values() if v < 0)
    leaving = sum(v for v in outflow.values() if v > 0)
    result.balances["fluid volume"] = _balance(entering, leaving, 0.0, 0.0, "m3/s")
    result.nodal |= {"u": (flow.system.fields["u"][0], flow.velocity), "p": (flow.system.fields["p"][0], flow.pressure)}
    from contbed.packed_bed.results import flow_findings

    flow_findings(plan, flow, result)
    return flow


def _balance(
    entering: float, leaving: float, source: float, stored: float, unit: str, floor: float = 1e-300
) -> dict[str, Any]:
    scale = max(abs(entering), abs(leaving), abs(source), abs(stored), floor)
    residual = (entering + source - leaving - stored) / scale
    return {
        "in": entering,
        "out": leaving,
        "source": source,
        "stored": stored,
        "relative_residual": residual,
        "unit": unit,
    }


def _heat_balance(fluxes: Any, reactions: Any, source: float, stored: float, unit: str, held: float) -> dict[str, Any]:
    parts = [value for flux in fluxes.values() for value in flux.values()] + list(reactions.values())
    entering, leaving = sum(v for v in parts if v > 0), -sum(v for v in parts if v < 0)
    return _balance(entering, leaving, source, stored, unit, max(NOTICED * held, 1e-300))


def _steady_balance(problem: Any, state: Any, residual: Any) -> tuple[Any, Any, dict[str, Any]]:
    """Heat through boundaries, heat conducted in by prescribed temperatures, and their balance."""
    fluxes, reactions = problem.fluxes(state), problem.reactions(residual)
    balance = _heat_balance(fluxes, reactions, problem.source(), 0.0, "W", problem.throughput())
    return fluxes, reactions, balance


def _steady(plan: Plan, problem: Any, result: Result, last: bool) -> Any | None:
    """Solve and report; or, on a mesh that may still be refined and should be, return the error of each cell."""
    from contbed.packed_bed.results import steady_findings

    with _timed(result, "heat"):
        state, history = problem.solve(plan.policy)
        result.history += history
        residual, _ = problem.steady(state, False)
        fluxes, reactions, balance = _steady_balance(problem, state, residual)
        if abs(balance["relative_residual"]) > 0.1 * plan.scene.solver.balance_tolerance:
            state, residual = problem.refined(state, plan.policy)
            fluxes, reactions, balance = _steady_balance(problem, state, residual)
    with _timed(result, "results"):
        if plan.adaptations:
            error = problem.estimated_error(state)
            if not last and error.max() > plan.scene.solver.tolerance:
                return error
            result.qoi["estimated_error"] = float(error.max())
        result.balances["energy"] = balance
        steady_findings(plan, problem, state, fluxes, reactions, result)
        _check_state(plan, problem, [state], result)
    return None


def _transient(
    scene: s.Scene,
    plan: Plan,
    problem: Any,
    result: Result,
    folder: Path | None,
    quiet: bool,
    start: tuple[Any, Any] | None,
) -> None:
    from contbed.output import checkpoint
    from contbed.output.progress import Progress
    from contbed.packed_bed.results import transient_findings
    from contbed.packed_bed.transient import History, integrated_fluxes, run_transient
    from contbed.scene.loading import scene_hash

    assert scene.time is not None
    label = scene_hash(scene)
    history = History(problem.begin(plan.policy)) if start is None else History.unpack(*start)

    def save(arrays: dict[str, Any], meta: dict[str, Any]) -> None:
        assert folder is not None
        checkpoint.save(folder, arrays, meta | {"scene_hash": label})

    try:
        with _timed(result, "heat"), Progress(scene.time.end, "s", quiet) as progress:
            run_transient(
                problem, history, plan.policy, advance=progress.advance_to, save=save if folder is not None else None
            )
    finally:
        with _timed(result, "results"):
            if history.steps:
                fluxes, reactions = integrated_fluxes(problem, history), problem.reaction_sums(history.reaction)
                source = problem.source() * history.time
                held = problem.throughput() * history.time + problem.capacity()
                result.balances["energy"] = _heat_balance(fluxes, reactions, source, history.gain, "J", held)
            transient_findings(plan, problem, history, result)
            if history.snapshots:
                problem.steady(history.snapshots[-1], False)  # closures as used at the last output
            _check_state(plan, problem, history.snapshots, result)
        if folder is not None:
            save(*history.pack())


def _track_fronts(plan: Plan, result: Result) -> None:
    from contbed.packed_bed.equations.fronts import track
    from contbed.packed_bed.results import front_findings

    scene, medium = plan.scene, plan.medium
    time, bed = scene.time, scene.bed
    assert time is not None
    u = float(plan.velocity[0])
    times = sorted({*time.times, time.end})
    snapshots, sums = track(
        scene.mesh.length,  # type: ignore[union-attr]
        plan.mesh.skfem.nelements,
        abs(u) / bed.porosity,
        bed.porosity * medium.fluid.density(300.0) * medium.fluid.heat_capacity(300.0),
        (1.0 - bed.porosity) * medium.solid.density(300.0) * medium.solid.heat_capacity(300.0),
        float(medium.exchange(medium.T_fluid_in, lambda density: abs(u))),
        medium.T_fluid_in,
        (time.initial_fluid, time.initial_solid),
        times,
    )
    result.closures = [use.to_dict() for use in medium.ranges()]
    sums = {name: value * plan.section for name, value in sums.items()}
    result.balances["energy"] = _balance(sums["in"], sums["out"], 0.0, sums["stored"], "J")
    front_findings(plan, snapshots, u < 0, result)


def _check_state(plan: Plan, problem: Any, states: list[Any], result: Result) -> None:
    """Closure ranges at the last state, material ranges and bounds of theta over all states; nothing is clipped."""
    if not states:
        return
    result.closures = [use.to_dict() for use in plan.medium.ranges()]
    result.warnings += [_outside(closure) for closure in result.closures if closure["share_outside"] > 0]
    for phase in ("fluid", "solid"):
        material = getattr(plan.medium, phase)
        values = problem.system.part(states[-1], f"T_{phase}")
        if (share := material.share_outside(values)) > 0:
            low, high = material.T_range
            result.warnings.append(
                f"{material.name}: {share:.1%} of the points are outside {low:.6g} to {high:.6g} K, used "
                f"{values.min():.6g} to {values.max():.6g} K"
            )
    low, high = problem.T_span
    has_heat = problem.source() or any(
        table.flux for b in plan.scene.boundary.values() for table in (b.fluid, b.solid) if table is not None
    )
    if has_heat or high <= low:
        return
    both = [problem.system.part(state, name) for state in states for name in ("T_fluid", "T_solid")]
    beyond = max(max(float(T.max()) - high, low - float(T.min())) for T in both) / (high - low)
    result.qoi["theta_overshoot"] = max(beyond, 0.0)
    if beyond > OVERSHOOT:
        result.warnings.append(
            f"theta leaves [0, 1] by {beyond:.2g}: a layer is not resolved; refine the mesh or leave out mesh.cells"
        )


def _keep_last(scene: s.Scene, error: ConvergenceError, folder: Path | None) -> None:
    """A steady run keeps its last Newton state beside the summary."""
    if folder is None or error.state is None or scene.time is not None:
        return
    from contbed.output import checkpoint
    from contbed.scene.loading import scene_hash

    checkpoint.save(folder, {"state": np.asarray(error.state)}, {"scene_hash": scene_hash(scene)})
