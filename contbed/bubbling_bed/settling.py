"""Sizes of the particles of a bed by feed, drain and carry-over, and height of the bed,
which follow from its state.

    F x_f,i = F_d x_i + A w k_i x_i,   sum_i x_i = 1          mass of size i of one solid phase
    k_i = K_i + s (E - K_i),   s = (C - C_inf)/(E - C_inf)    what the end of the freeboard passes
    int (1 - delta) dz = H_mf,  or  H = H_mf R                height by its bubbles, or by a closure's mean ratio R

F, F_d   feed and drain [kg/s]            x_f,i, x_i   share of size i in the feed and in the bed
A        section [m2]                     w            share of the phase in the mass of the bed
K_i      elutriation rate constant at the end of the freeboard [kg/m2/s]
E        particles that bubbles throw up [kg/m2/s]           s      share of them that has not fallen back
C        particles that leave the freeboard [kg/m2/s]        C_inf  those of a freeboard without end, sum w x_i K_i

The drain keeps the inventory, whose share `volume_share` the scene gives; particles
neither shrink nor break. Both follow from the state and change its coefficients: bed
and settling are solved in turn on one stretched mesh until neither changes.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.optimize import brentq

from contbed.bubbling_bed.burning import BURNING, burns, explained, heat_balance
from contbed.bubbling_bed.diagnosis import char
from contbed.bubbling_bed.plan import BubblingPlan, line
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.bubbling_bed.scene_coefficients import coefficients
from contbed.errors import ConvergenceError
from contbed.result import Result
from contbed.solvers.continuation import from_easier

CHANGE = 1e-9  # relative, of sizes and height, below which the bed has settled
ROUNDS = 60


def unsettled(scene: Any) -> bool:
    """Return whether sizes or the height of the bed follow from its state."""
    sized = any(
        item.sizes is not None and item.sizes.bed is None
        for item in scene.present.values()
    )
    return sized or scene.bubbling_bed.settled_height is not None


def settle(
    problem: BubblingProblem, state: Any, result: Result
) -> tuple[BubblingProblem, Any]:
    """Solve for sizes, height and state in turn until none changes; return the
    problem and its state.
    """
    for _ in range(ROUNDS):
        scene, change = settled(problem, state, result)
        watch, before = problem.watch, problem
        problem = stretched(before.plan, scene)
        problem.watch = watch
        x = before.unknowns(state)
        rises = scene.bubbling_bed.settled_height is not None
        try:
            # steps in time would cost more than the way over heights between both, and
            # may lead to a bed that is out
            state, history = problem.solve_from(x, near=rises)
        except ConvergenceError as error:
            if not rises:
                raise
            x = _followed(before, x, scene, error)
            state, history = problem.solve_from(x)
        result.history += history[1:]
        if change < CHANGE:
            return problem, state
    raise ConvergenceError(
        "particle sizes and bed height did not converge: they still change "
        f"by {change:.2g} of their values in each iteration; change the feed "
        "or give the height",
        result.history,
        state,
    )


def _followed(
    problem: BubblingProblem, x: Any, scene: Any, failure: ConvergenceError
) -> Any:
    """Return unknowns of a scene whose height is far from that of a problem, followed
    from the unknowns of that over heights between both; those of the problem where
    they cannot be followed and nothing burns.

    Raises
    ------
    ConvergenceError : fuel burns and they cannot be followed, with what the last state
        says and the history of the `failure` of the whole step
    """
    old, bed = problem.plan.scene.bubbling_bed.height, scene.bubbling_bed
    last, at_last = x, problem

    def at(left: float, near: Any) -> Any:
        nonlocal last, at_last
        height = bed.height + left * (old - bed.height)
        between = bed.model_copy(update={"height": height})
        changed = scene.model_copy(update={"bubbling_bed": between})
        here = stretched(problem.plan, changed)
        last, at_last = here.solve_near(near)[0], here
        return last

    try:
        return from_easier(at, x)
    except ConvergenceError:
        if not burns(problem):
            return x
        raise _no_height(at_last, last, bed.height, failure) from None


def _no_height(
    problem: BubblingProblem, x: Any, wanted: float, failure: ConvergenceError
) -> ConvergenceError:
    """Return the error of a bed of fuel that was followed to the height of a problem,
    on the way to the `wanted` one, with the history of the `failure` there.
    """
    scene = problem.plan.scene
    why = explained(problem)
    if heat_balance(problem, BURNING).surplus > 0.0:
        why = char(problem, x) or why
    text = (
        f"{scene.origin.at(('bubbling_bed', 'settled_height'))}: "
        f"bubbling_bed.settled_height = {scene.bubbling_bed.settled_height:g} m: the "
        f"bed would be {wanted:.3g} m high with its bubbles, and no steady state is "
        f"found beyond {scene.bubbling_bed.height:.3g} m: {why}; or give a smaller "
        "settled_height"
    )
    return ConvergenceError(text, failure.history, x)


def stretched(
    plan: BubblingPlan, scene: Any, typical: dict[str, Any] | None = None
) -> BubblingProblem:
    """Return the problem of a scene on the mesh of a plan, stretched to its height;
    `typical` as in `coefficients`.
    """
    ratio = scene.bubbling_bed.height / plan.scene.bubbling_bed.height
    mesh = plan.mesh
    if ratio != 1.0:
        mesh = line(ratio * np.sort(mesh.skfem.p[0]))
    c = coefficients(scene, typical)
    return BubblingProblem(replace(plan, scene=scene, coefficients=c, mesh=mesh))


def settled(problem: BubblingProblem, state: Any, result: Result) -> tuple[Any, float]:
    """Return the scene with sizes and height by a state, and the largest relative
    change.
    """
    scene: Any = problem.plan.scene
    changes, solids = [0.0], dict(scene.solids)
    for name, item in scene.present.items():
        if item.sizes is None or item.sizes.feed is None:
            continue
        shares, drain = sizes_in_bed(problem, state, name)
        diameter = 1.0 / float(np.sum(shares / np.array(item.sizes.diameters)))
        changes.append(abs(diameter / item.diameter - 1.0))
        sizes = item.sizes.model_copy(update={"bed": tuple(shares)})
        solids[name] = item.model_copy(update={"diameter": diameter, "sizes": sizes})
        result.qoi |= {
            f"{name}_diameter_m": diameter,
            f"{name}_drain_kg_s": drain,
            f"{name}_carryover_kg_s": item.feed.mass_flow - drain,
        }
    bed = scene.bubbling_bed
    if bed.settled_height is not None:
        height = height_of(problem, state)
        changes.append(abs(height / bed.height - 1.0))
        bed = bed.model_copy(update={"height": height})
        result.qoi["bed_height_m"] = height
    changed = scene.model_copy(update={"solids": solids, "bubbling_bed": bed})
    return changed, max(changes)


def sizes_in_bed(problem: BubblingProblem, state: Any, name: str) -> tuple[Any, float]:
    """Return the mass shares of the sizes in the bed, and the drain [kg/s]."""
    item: Any = problem.plan.scene.solids[name]
    above = problem.above
    # the first node is the end of the freeboard
    end = {
        key: problem.system.part(state, key)[:1]
        for key in (*above.part.fields, *problem.c.scalars)
    }
    unknowns = SimpleNamespace(**end)
    there = above.state(unknowns)[0]
    rates = np.array([float(np.squeeze(rate)) for rate in above.rates(there, name)])
    thrown = problem.at(lambda u, o: u.flow_up, problem.top, state)
    endless = float(np.squeeze(above.local_coefficients(unknowns, None).carried))
    if thrown != endless:
        share = (float(unknowns.carryover[0]) - endless) / (thrown - endless)
        rates = rates + share * (thrown - rates)
    carried = above.computed.section * above.shares[name] * rates
    feed, given = item.feed.mass_flow, np.array(item.sizes.feed)

    def excess(drain: float) -> float:
        return float(np.sum(feed * given / (drain + carried))) - 1.0

    least = 1e-12 * feed
    if excess(least) < 0:
        raise ConvergenceError(
            f"solids {name}: {feed:.3g} kg/s are fed, and the gas carries away more at "
            f"the given inventory ({carried @ given:.3g} kg/s of the sizes of the "
            "feed); feed more or coarser particles, or raise "
            "bubbling_bed.freeboard.height",
            [],
            state,
        )
    drain = (
        feed
        if excess(feed) >= 0
        else brentq(excess, least, feed, xtol=1e-15 * feed, rtol=1e-14)
    )
    return feed * given / (drain + carried), float(drain)


def height_of(problem: BubblingProblem, state: Any) -> float:
    """Return the height [m] of the bed that holds the particles of `settled_height`."""
    bed: Any = problem.plan.scene.bubbling_bed
    c = problem.c
    if problem.plan.scene.closures.expansion is not None:
        ratio = (
            problem.total(lambda u, o: c.computed.expansion(u, o), state) / bed.height
        )
        return float(bed.settled_height * ratio)
    filled = problem.total(lambda u, o: 1.0 - c.at(u, o).delta, state)
    return float(bed.height * bed.settled_height / filled)
