"""Ways to the state of a bed that reacts, which Newton's method does not reach from one
temperature: hot beds that cool slowly, gases that mix slowly at first, and cold beds.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from contbed.bubbling_bed.burning import explained, is_out
from contbed.errors import ConvergenceError
from contbed.solvers.continuation import from_easier

# factor by which the heat of a hot bed changes slower than its fuel and gas
SLOWER = 1e3
HOT = 1500.0  # temperature from which a burning bed is followed last [K]
# times in which gases mix [s]: flames fill the bed, and flames are fronts that shorter
# times do not change
SLOW_MIXING, FAST_MIXING = 3.0, 1e-4
# the slow one of gases that burn without fuel [s]: they leave the bed within a second,
# and go out where they mix no faster
SLOW_IN_GAS = 0.02
SLOW_LIME = 0.03  # of the rate of calcination, at which it fills the bed
COLD = 600.0  # temperature of a bed [K] in which lime does not give off gas yet
# of the rates of reactions above a bed, at which gases of any flame hardly react there
SLOW_ABOVE = 1e-8
WIDER = 1.2  # times the shortest time of mixing with a state, which is advised


class NarrowFlameError(ConvergenceError):
    """A burning bed whose state is found only for gases that mix more slowly."""


def burning_state(problem: Any, T: float, given: bool) -> tuple[Any, list[float]]:
    """Solve a bed that burns fuel from one temperature, or by following a hot bed.

    A state without fire is accepted from a `given` temperature, or where no other is
    found.

    Raises
    ------
    ConvergenceError : no state is found, with what the heat balance says
    """
    hot = max(T, HOT)
    # a bed that cools before its fuel is there goes out; heat that changes slowly leaves
    # it hot until its inventory of fuel and the gas are those that belong to it
    ways: tuple[Callable[[], Any], ...] = (
        lambda: problem.settled(T),
        lambda: problem.settled(T, SLOWER),
        lambda: from_slow_mixing(problem, hot),
        lambda: problem.settled(hot, SLOWER),
    )
    extinguished: tuple[Any, list[float]] | None = None
    failures: list[ConvergenceError] = []
    for start in ways:
        try:
            found: tuple[Any, list[float]] = problem.solve_from(start())
        except ConvergenceError as error:
            failures.append(error)
            continue
        if given or not is_out(problem, found[0]):
            return found
        extinguished = extinguished or found
    if extinguished is not None:
        return extinguished
    narrow = [each for each in failures if isinstance(each, NarrowFlameError)]
    if narrow:
        raise narrow[0]
    first = failures[0]
    raise ConvergenceError(f"{first}; {explained(problem)}", first.history, first.state)


def reacting_state(problem: Any, T: float) -> tuple[Any, list[float]]:
    """Solve a bed that reacts without fuel from one temperature, or else from a colder
    one, in which particles do not give off gas at once, or from limestone that reacts
    slowly; where gases may burn, by following them from slow mixing first, as their
    flames may be narrow.

    Raises
    ------
    ConvergenceError : no state is found
    """
    scene = problem.plan.scene
    found: tuple[Any, list[float]]
    burn = scene.reactions.of_gases and "O2" in problem.chemistry.part.inlet
    if burn and scene.bubbling_bed.mixing_time < SLOW_IN_GAS:
        with suppress(ConvergenceError):
            slow = from_slow_mixing(problem, T, SLOW_IN_GAS)
            found = problem.solve_from(slow, near=True)
            return found
    try:
        found = problem.solve_from(problem.settled(T))
    except ConvergenceError:
        if T <= COLD:
            raise
        with suppress(ConvergenceError):
            found = problem.solve_from(problem.settled(COLD))
            return found
        if scene.reactions.calcination is None:
            raise
        with suppress(ConvergenceError):
            found = problem.solve_from(from_slow_lime(problem, T), near=True)
            return found
        raise
    return found


def with_freeboard(
    problem: Any, solve: Callable[[], tuple[Any, list[float]]]
) -> tuple[Any, list[float]]:
    """Solve a bed with gases that react above it: from the state in which they do not,
    whose flames are in the bed alone; where that cannot be followed, as `solve` does.

    Raises
    ------
    ConvergenceError : no state is found
    """
    try:
        problem.react_above(SLOW_ABOVE)
        state, _ = solve()
        with suppress(ConvergenceError):
            if not is_out(problem, state):
                return followed_above(problem, problem.unknowns(state))
    finally:
        problem.react_above(1.0)
    return solve()


def followed_above(problem: Any, x: Any) -> tuple[Any, list[float]]:
    """Solve with gases that react above the bed, followed from unknowns `x` with those
    that hardly do.

    Raises
    ------
    ConvergenceError : they cannot be followed
    """

    def follow(left: float, near: Any) -> Any:
        problem.react_above(SLOW_ABOVE**left)
        return problem.solve_near(near)[0]

    problem.react_above(1.0)
    found: tuple[Any, list[float]]
    with suppress(ConvergenceError):
        found = problem.solve_from(x, near=True)
        return found
    with np.errstate(all="ignore"):
        x = from_easier(follow, x)
    found = problem.solve_from(x, near=True)
    return found


def from_slow_lime(problem: Any, T: float) -> Any:
    """Return unknowns of a bed of limestone, followed from SLOW_LIME of the rate at
    which it calcines: it leaves nearly no CaCO3, in fronts, where it is fast.

    Raises
    ------
    ConvergenceError : no state is found
    """
    slow = with_lime(problem, 1.0)
    state, _ = slow.solve_from(slow.settled(T))
    with np.errstate(all="ignore"):
        return from_easier(
            lambda left, near: with_lime(problem, left).solve_near(near)[0],
            slow.unknowns(state),
        )


def with_lime(problem: Any, left: float) -> Any:
    """Return a problem whose limestone calcines at SLOW_LIME of its rate at 1, and as
    its scene says at 0.
    """
    scene, reactions = problem.plan.scene, problem.plan.scene.reactions
    factor = reactions.calcination.factor * SLOW_LIME**left
    slow = reactions.calcination.model_copy(update={"factor": factor})
    changed = reactions.model_copy(update={"calcination": slow})
    return problem.with_scene(scene.model_copy(update={"reactions": changed}))


def from_slow_mixing(problem: Any, T: float, slowest_time: float = SLOW_MIXING) -> Any:
    """Return unknowns of a bed that burns, followed from gases that mix in
    `slowest_time` [s].

    Flames are then as wide as the bed, and become narrow fronts on the way.

    Raises
    ------
    NarrowFlameError : they cannot be followed to the time of mixing of the scene
    ConvergenceError : no state is found for gases that mix slowly either
    """
    slowest = with_mixing(problem, 1.0, slowest_time)
    state, _ = slowest.solve_from(slowest.settled(T))
    reached = slowest_time

    def follow(left: float, near: Any) -> Any:
        nonlocal reached
        there = with_mixing(problem, left, slowest_time)
        x, _ = there.solve_near(near)
        reached = there.plan.scene.bubbling_bed.mixing_time
        return x

    try:
        # states between may leave the range of a property
        with np.errstate(all="ignore"):
            return from_easier(follow, slowest.unknowns(state))
    except ConvergenceError as error:
        scene = problem.plan.scene
        wanted = scene.bubbling_bed.mixing_time
        raise NarrowFlameError(
            f"{scene.origin.at(('bubbling_bed',))}: bubbling_bed: no steady state is "
            "found: flames are narrower than cells of the mesh at "
            f"bubbling_bed.mixing_time = {wanted:g} s; give {WIDER * reached:.2g} s, "
            "for which a burning bed is found, or mesh.refine = "
            f"{scene.mesh.refine + 1}",
            error.history,
            error.state,
        ) from error


def with_mixing(problem: Any, left: float, slowest_time: float) -> Any:
    """Return a problem with another time in which gases mix: `slowest_time` [s] at 1,
    and that of its scene at 0.
    """
    scene, bed = problem.plan.scene, problem.plan.scene.bubbling_bed
    time = bed.mixing_time
    if left > 0.0:
        time = max(time, FAST_MIXING) ** (1.0 - left) * slowest_time**left
    slow = bed.model_copy(update={"mixing_time": time})
    changed = scene.model_copy(update={"bubbling_bed": slow})
    return problem.with_scene(changed)
