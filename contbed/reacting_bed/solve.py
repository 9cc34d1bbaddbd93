"""Steady states of a reacting bed: Newton's method, its fallbacks, and adaptive
cells.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from contbed.arrays import Array
from contbed.chemistry.local import FINEST, Smoothing
from contbed.errors import ConvergenceError
from contbed.reacting_bed.cells import MOST_CELLS, halves, moved, next_cells
from contbed.reacting_bed.equations.unknowns import Role
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.rate_checks import rate_without_value, taken_to_the_end
from contbed.reacting_bed.storage import Storage

LARGEST_T = 150.0  # change of a temperature in one step [K]
LARGEST_SHARE = 0.7  # of an amount that a step may take away
LEAST_SHARE = 1e-3  # of the typical size, below which a fall is not held up
SHORTEST = 1e-3  # step of Newton's method at which it is given up
# iterations in which the least residual has to fall by this factor
PROGRESS, PATIENCE = 0.8, 14
# residual at which a step of a march in time, which need not be exact, is taken
LOOSE = 1e-5
# residual that is rounding, after which a step is the last of which so many times the
# tolerance is left
ROUNDED, NEAR_ROUNDING = 1e-12, 1e3
FIRST_CELLS = 24  # of the first mesh, which only has to show where the fronts are
ROUNDS = 10  # of better cells at most, each from the estimate on the last ones
FIRST_ITERATIONS = 60  # of Newton's method from a first guess
FEW_ITERATIONS = 15  # where the guess is near
# share of a gas or solid below which its powers are straight lines, to begin with
SMOOTHEST = 0.1
# and above which a march in time looks for a state with sharper ones
COARSE = 1e-3
# factor from one such share to the next, and beyond which no sharper is tried
SHARPER, LEAST_SHARPER = 0.1, 0.7
# shares of their rates at which reactions are tried where they find no state, and the
# factors of the way from there, the first and the least
SLOW = (0.1, 0.01)
FASTER, LEAST_FASTER = 3.0, 1.05
STEPS = 120  # of the march in time
GROWTH, SHORTER = 1.6, 0.25  # of its steps
MOST_FAILURES = 15  # in a row, after which steps are 1e-9 of the first
# of the march on the same cells, before these are put where the fronts have gone
STEPS_PER_CELLS = 3
STILL = 1e-7  # largest change in a step, over typical sizes, of a state that is steady
EVEN_CELLS = 30  # that are put between the first ones for the march
START_OF_MARCH = 1e-2  # of the residence time of the solids
END_OF_MARCH = 1e5  # of it: a state that has not become steady by then does not


@dataclass
class Report:
    """What the solution took."""

    history: list[float] = field(default_factory=list)
    rounds: int = 0
    # change of what leaves between the last two meshes over what enters
    estimate: float = np.inf
    marched: bool = False
    stopped: bool = False  # whether no state was found on better cells
    # whether no sharper powers of what is left of solids are tried
    sharpest: bool = False
    # share of a gas or solid below which its powers are straight lines; 0 for that of
    # the laws
    small: float = 0.0
    damped: int = (
        0  # cells in which amounts would fall below zero, see `steady_positivity`
    )
    damping_changes: float = 0.0  # what leaves, over what enters


def scaled_residual_norm(problem: Problem, residual: Array) -> float:
    """Return the maximum norm of a residual, each equation divided by its flux scale."""
    largest = np.abs(residual).max(axis=(1, 2))
    return float((largest / problem.flux_sizes).max())


def damping_factor(problem: Problem, u: Array, du: Array) -> float:
    """Return the largest step length in (0, 1] that changes no temperature by more than
    `LARGEST_T` and takes no more than `LARGEST_SHARE` of an amount.
    """
    factor = 1.0
    for k, each in enumerate(problem.unknowns):
        step = du[k]
        if each.is_temperature:
            largest = max(float(np.abs(step).max()), 1e-300)
            factor = min(factor, LARGEST_T / largest)
        # isotherms are concave: Newton's method needs no shorter steps
        elif each.role is not Role.POINT:
            gas = each.role is Role.GAS
            typical = problem.moles if gas else problem.sizes[k]
            size = typical * (np.sign(u[k].mean()) if gas else 1.0)
            size = np.where(size == 0.0, typical, size)
            value, decrease = u[k] / size, -step / size
            allowed = LARGEST_SHARE * np.maximum(value, LEAST_SHARE * 10)
            too_large = decrease > allowed
            if too_large.any():
                ratios = allowed[too_large] / decrease[too_large]
                factor = min(factor, float(ratios.min()))
    return factor


def newton_step(
    problem: Problem, u: Array, report: Report, storage: Storage | None = None
) -> tuple[Array, float, float]:
    """Return a step of Newton's method, its damping, and the norm of the residual
    before.

    Raises
    ------
    ConvergenceError : a residual or a step is not finite
    """
    with np.errstate(all="ignore"):
        residual, slopes = problem.system.assemble(u)
        if storage is not None:
            residual = storage.add(u, residual, slopes)
        norm = scaled_residual_norm(problem, residual)
        if not np.isfinite(norm):
            what = rate_without_value(problem, u) or "a rate or property is not finite"
            raise convergence_error(what, problem, u, report, storage)
        report.history.append(norm)
        du = slopes.factors(problem.flux_sizes, problem.sizes).solve(-residual)
        damping = damping_factor(problem, u, du)
    if not np.isfinite(du).all():
        what = "a step of Newton's method is not finite"
        raise convergence_error(what, problem, u, report, storage)
    return du, damping, norm


def newton(
    problem: Problem,
    u: Array,
    report: Report,
    storage: Storage | None = None,
    max_iterations: int = 0,
) -> Array:
    """Return the solution of the steady equations, or of a step in time where `storage`
    adds to them.

    Raises
    ------
    ConvergenceError : it does not converge; the error carries the last state
    """
    options = problem.scene.solver
    scale = problem.sizes[:, None, None]
    loose = storage is not None and storage.loose
    best, norm, stalled_iterations = np.inf, np.inf, 0
    for _ in range(max_iterations or options.newton_iterations):
        du, damping, norm = newton_step(problem, u, report, storage)
        if damping < SHORTEST:
            what = "Newton's method takes ever smaller steps"
            raise convergence_error(what, problem, u, report, storage)
        if norm < PROGRESS * best:
            best, stalled_iterations = norm, 0
        else:
            stalled_iterations += 1
        if stalled_iterations > PATIENCE:
            break
        u = u + damping * du
        change = float(np.abs(du / scale).max())
        if damping == 1.0 and converged(norm, change, options.newton_tolerance, loose):
            return u
    what = f"Newton's method stops at a residual of {norm:.2g}"
    raise convergence_error(what, problem, u, report, storage)


def converged(norm: float, change: float, tolerance: float, loose: bool) -> bool:
    """Return whether a full step is the last.

    Parameters
    ----------
    norm : of the residual before the step
    change : largest of the step over typical sizes
    loose : whether the solution need not be exact
    """
    if change < tolerance:
        return True
    if norm < ROUNDED and change < NEAR_ROUNDING * tolerance:
        return True
    return loose and norm < LOOSE and change < LOOSE**0.5


def convergence_error(
    text: str,
    problem: Problem,
    u: Array,
    report: Report,
    storage: Storage | None = None,
) -> ConvergenceError:
    """Return the error of a state, which says where in the bed and for what its
    residuals are largest.
    """
    with np.errstate(all="ignore"):
        residual = problem.system.assemble(u, False)[0]
        if storage is not None:
            residual = residual + storage.residual(u)
        sizes = np.abs(residual).max(axis=2) / problem.flux_sizes[:, None]
    k, cell = divmod(int(sizes.argmax()), sizes.shape[1])
    worst, x = problem.unknowns[k], problem.line.vertices[cell]
    species = worst.species or worst.name
    where = f"the largest residual is that of {species} at x = {x:.4g} m"
    parts = (text, where, taken_to_the_end(problem, u))
    return ConvergenceError("; ".join(filter(None, parts)), report.history, u)


def residence_time(problem: Problem) -> float:
    """Return the time that particles, or gas through a bed at rest times 1000, take
    through the bed [s].
    """
    length = problem.line.vertices[-1] - problem.line.vertices[0]
    v = abs(problem.bed.velocity_solid)
    if v:
        return float(length / v)
    return 1e3 * float(length / abs(problem.state_entering().u))


def march(problem: Problem, u: Array, report: Report) -> tuple[Problem, Array]:
    """Go to a steady state by steps in time of growing length, in which the gas is
    quasi-steady, on adaptive cells.

    Raises
    ------
    ConvergenceError : steps no longer grow
    """
    tau = residence_time(problem)
    dt, longest, failures, taken = START_OF_MARCH * tau, 0.0, 0, 0
    report.marched = True
    adapts = problem.scene.mesh.cells is None
    while dt < END_OF_MARCH * tau and taken < STEPS:
        try:
            found = newton(
                problem,
                u,
                report,
                Storage.after(problem, u, dt),
                max_iterations=FEW_ITERATIONS,
            )
        except ConvergenceError as error:
            dt *= SHORTER
            failures += 1
            if failures > MOST_FAILURES:
                text = f"the longest step in time that converged is {longest:.3g} s"
                state = u if error.state is None else error.state
                raise convergence_error(text, problem, state, report) from None
            continue
        change = float(np.abs((found - u) / problem.sizes[:, None, None]).max())
        u, taken, longest = found, taken + 1, max(longest, dt)
        if change < STILL and dt > tau:
            break
        dt *= GROWTH
        if adapts and taken % STEPS_PER_CELLS == 0:
            other = problem.on(next_cells(problem, u)[0])
            problem, u = other, moved(problem, u, other)
    return problem, u


def steady(
    problem: Problem, report: Report, guess: Array | None = None
) -> tuple[Problem, Array]:
    """Return the steady state on cells adapted to its errors.

    Raises
    ------
    ConvergenceError : no steady state is found
    """
    scene = problem.scene
    T = scene.initial.temperature or problem.mixing_temperature
    problem, u = first(
        problem, guess if guess is not None else problem.start(T), report
    )
    if scene.mesh.cells is not None:
        report.rounds = 0
        return problem, u
    rounds = ROUNDS if scene.solver.adapt is None else scene.solver.adapt
    leaving, before = what_leaves(problem, u), np.inf
    for _ in range(rounds):
        vertices, worst = next_cells(problem, u)
        good = report.estimate < scene.solver.tolerance
        if good and (worst <= 1.0 or before < scene.solver.tolerance):
            break
        better = on_better_cells(problem, u, vertices, report)
        if better is None:
            report.stopped = True
            break
        problem, u = sharper(*better, report)
        report.rounds += 1
        now = what_leaves(problem, u)
        before, report.estimate = report.estimate, float(np.abs(now - leaving).max())
        leaving = now
    return problem, u


def on_better_cells(
    problem: Problem, u: Array, vertices: Array, report: Report
) -> tuple[Problem, Array] | None:
    """Return the state on other cells, or else on halves of the present ones; None
    if it is found on neither.
    """
    for chosen in (vertices, halves(problem)):
        if len(chosen) > MOST_CELLS:
            continue
        other = problem.on(chosen)
        at_start = moved(problem, u, other)
        with np.errstate(all="ignore"):
            try:
                return other, newton(other, at_start, report)
            except ConvergenceError:
                pass
            try:
                if problem.has_roots:
                    report.sharpest = True
                    return sharpened(other, at_start, report)
            except ConvergenceError:
                continue
    return None


def first(problem: Problem, u: Array, report: Report) -> tuple[Problem, Array]:
    """Return a steady state on the first cells, or on halves of them."""
    try:
        return on_cells(problem, u, report)
    except ConvergenceError:
        if problem.scene.mesh.cells is not None:
            raise
    finer = problem.on(halves(problem))
    try:
        return on_cells(finer, moved(problem, u, finer), report)
    except ConvergenceError:
        if not problem.reactions:
            raise
        with suppress(ConvergenceError):
            return followed_from_slow(problem, u, report)
        raise


def on_cells(problem: Problem, u: Array, report: Report) -> tuple[Problem, Array]:
    """Return a steady state on given cells: by Newton's method, and where that fails
    by what else helps.
    """
    with np.errstate(all="ignore"):
        try:
            return problem, newton(problem, u, report, max_iterations=FIRST_ITERATIONS)
        except ConvergenceError:
            pass
        if problem.has_roots:
            try:
                return sharpened(problem, u, report)
            except ConvergenceError:
                pass
        if problem.reactions:
            try:
                return problem, grown(problem, u, report)
            except ConvergenceError:
                pass
        problem, u = march(problem, u, report)
        return problem, newton(problem, u, report)


def sharpened(problem: Problem, u: Array, report: Report) -> tuple[Problem, Array]:
    """Return the state reached with powers of what is left made sharper step by step,
    on adaptive cells.

    Where reaction ends at a point, powers below one have infinite slopes there, and
    Newton's method goes from one side of zero to the other; the sharpest that converges
    is kept. Steps in time pass where Newton's method does not become sharp.
    """
    small, factor = SMOOTHEST, SHARPER
    done, u = smooth(problem.with_small(Smoothing(small, small)), u, report)
    while small > FINEST and factor < LEAST_SHARPER:
        cells = (
            done
            if problem.scene.mesh.cells is not None
            else done.on(next_cells(done, u)[0])
        )
        below = max(factor * small, FINEST)
        trial = cells.with_small(Smoothing(below, below))
        try:
            found = newton(
                trial, moved(done, u, trial), report, max_iterations=2 * FEW_ITERATIONS
            )
        except ConvergenceError:
            factor **= 0.5
            continue
        small, done, u = below, trial, found
    if small > COARSE:
        trial = done.with_small(Smoothing(COARSE, COARSE))
        try:
            trial, found = march(trial, u, report)
            found = newton(trial, found, report, max_iterations=FEW_ITERATIONS)
        except ConvergenceError:
            pass
        else:
            small, done, u = COARSE, trial, found
    report.small = small
    return done, u


def smooth(problem: Problem, u: Array, report: Report) -> tuple[Problem, Array]:
    """Return a state with smooth powers: by Newton's method, growing rates, or where
    heat matters a march in time.
    """
    try:
        return problem, newton(problem, u, report, max_iterations=FIRST_ITERATIONS)
    except ConvergenceError:
        pass
    if not problem.layout.temperatures:
        return problem, grown(problem, u, report)
    even = problem
    if problem.scene.mesh.cells is None:
        v = problem.line.vertices
        every = np.sort(
            np.concatenate([v, np.linspace(v[0], v[-1], EVEN_CELLS + 1)[1:-1]])
        )
        apart = np.concatenate([[True], np.diff(every) > np.diff(v).min()])
        apart[-1] = True
        even = problem.on(every[apart])
    try:
        return march(even, moved(problem, u, even), report)
    except ConvergenceError:
        return problem, grown(problem, u, report)


def sharper(problem: Problem, u: Array, report: Report) -> tuple[Problem, Array]:
    """Return the state with powers of what is left one step sharper, where that
    converges.
    """
    small = max(SHARPER * report.small, FINEST)
    if report.sharpest or not small < report.small:
        return problem, u
    trial = problem.with_small(Smoothing(small, small))
    try:
        u = newton(trial, u, report, max_iterations=FEW_ITERATIONS)
    except ConvergenceError:
        report.sharpest = True
        return problem, u
    report.small = small
    return trial, u


def smoothing_changes(problem: Problem, u: Array, report: Report) -> float:
    """Return by how much what leaves would change with powers as sharp as those of the
    laws, over what enters.

    By one whole step of Newton's method, which shows it where the method itself does
    not converge; 1 at most.
    """
    du, _, _ = newton_step(problem.with_small(None), u, report)
    change = np.abs(what_leaves(problem, u + du) - what_leaves(problem, u))
    return min(float(change.max()), 1.0)


def grown(problem: Problem, u: Array, report: Report) -> Array:
    """Return the steady state reached with all rates growing from a small share to
    their own values.
    """
    strength, step = 0.0, 0.02
    u = newton(problem.with_strength(0.0), u, report, max_iterations=FIRST_ITERATIONS)
    failures = 0
    while strength < 1.0:
        trial = min(1.0, strength + step)
        try:
            found = newton(problem.with_strength(trial), u, report, max_iterations=12)
        except ConvergenceError:
            step *= 0.3
            failures += 1
            if failures > 6 or step < 1e-5:
                raise
            continue
        u, strength = found, trial
        step *= 2.5
    return u


def followed_from_slow(
    problem: Problem, u: Array, report: Report
) -> tuple[Problem, Array]:
    """Return a steady state followed from that of slow reactions, on cells that shrink
    where their fronts become narrow.

    Raises
    ------
    ConvergenceError : no state of slow reactions is found, or it cannot be followed
    """
    for strength in SLOW:
        try:
            done, u = on_cells(problem.with_strength(strength), u, report)
        except ConvergenceError:
            if strength == SLOW[-1]:
                raise
            continue
        break
    factor = FASTER
    while strength < 1.0:
        above = min(1.0, factor * strength)
        trial = done.on(next_cells(done, u)[0]).with_strength(above)
        try:
            with np.errstate(all="ignore"):
                u = newton(
                    trial,
                    moved(done, u, trial),
                    report,
                    max_iterations=FIRST_ITERATIONS,
                )
        except ConvergenceError:
            factor **= 0.5
            if factor < LEAST_FASTER:
                raise
            continue
        done, strength = trial, above
    return done, u


def what_leaves(problem: Problem, u: Array) -> Array:
    """Return the fluxes of all equations at both ends over typical ones."""
    fluxes = problem.system.fluxes(u)
    found: Array = (fluxes[:, [0, -1]] / problem.flux_sizes[:, None]).ravel()
    return found
