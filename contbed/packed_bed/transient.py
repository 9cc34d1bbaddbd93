"""A transient two-energy run: steps, output times, balance over the whole run,
checkpoints and restart.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.packed_bed.heat import HeatProblem
from contbed.packed_bed.scene import Time
from contbed.packed_bed.streams import Outlets
from contbed.scene.toml_lines import Origin
from contbed.solvers.linear import Policy
from contbed.solvers.timestep import LEVELS, STAGES, WEIGHTS, Step, level_of, march

# [K] scale of the errors of a bed that only fluxes or sources drive from one
# temperature
ONE_KELVIN = 1.0

Save = Callable[[dict[str, Any], dict[str, Any]], None]


@dataclass
class History:
    """State of a transient run and its integrals over time so far.

    `mean` is the time integral of the state, `reaction` of the heat that prescribed
    temperatures conduct in by boundary, `flux` of the boundary fluxes where properties
    or boundary values vary, `gain` of the content; `ranges` is the record of how
    closures were used, see `Medium.state`; `outlet` holds time and outlet temperatures
    of each step, see `Outlets`, and the heat so far, see `by_streams`; `levels` are the
    sizes of the steps of this process.
    """

    state: Any
    time: float = 0.0
    tick: int = 0
    level: int | None = None
    steps: int = 0
    origin: float = 0.0  # where the ladder of steps begins and ends [s]
    end: float = 0.0
    times: list[float] = field(default_factory=list)
    snapshots: list[Any] = field(default_factory=list)
    mean: Any = 0.0
    reaction: Any = 0.0
    flux: dict[str, float] = field(default_factory=dict)
    gain: float = 0.0
    ranges: dict[str, Any] = field(default_factory=dict)
    outlet: list[tuple[float, ...]] = field(default_factory=list)
    levels: list[int] = field(default_factory=list)

    def pack(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the arrays and numbers of a checkpoint."""
        arrays = {
            "state": self.state,
            "mean": np.asarray(self.mean),
            "reaction": np.asarray(self.reaction),
            "times": np.array(self.times),
            "snapshots": np.array(self.snapshots),
            "outlet": np.array([row for row in self.outlet if row[0] <= self.time]),
            "sums": np.array([self.time, self.gain]),
            "flux": np.array(list(self.flux.values())),
            **self.ranges,
        }
        return arrays, {
            "tick": self.tick,
            "level": self.level,
            "steps": self.steps,
            "origin": self.origin,
            "end": self.end,
            "flux": list(self.flux),
        }

    @classmethod
    def unpack(cls, arrays: dict[str, Any], meta: dict[str, Any]) -> History:
        """Restore the history from a checkpoint."""
        return cls(
            state=arrays["state"],
            time=float(arrays["sums"][0]),
            tick=meta["tick"],
            level=meta["level"],
            steps=meta["steps"],
            origin=meta["origin"],
            end=meta["end"],
            times=list(arrays["times"]),
            snapshots=list(arrays["snapshots"]),
            outlet=[tuple(row) for row in arrays["outlet"].tolist()],
            mean=arrays["mean"],
            reaction=arrays["reaction"],
            flux=dict(
                zip(meta["flux"], (float(v) for v in arrays["flux"]), strict=True)
            ),
            gain=float(arrays["sums"][1]),
            ranges={
                name: rows
                for name, rows in arrays.items()
                if name.startswith("ranges_")
            },
        )

    def fitted(self, time: Time, where: Origin) -> History:
        """Return the history as if the run had been asked for this end and these output
        times from its start.

        Raises
        ------
        SceneError : an output time has passed and was not kept, or the end has passed
        """
        if time.end < self.time * (1 - 1e-12):
            text = f"lies before {self.time:g} s, which the checkpoint has reached"
            raise SceneError(
                f"{where.at(('time', 'end'))}: time.end = {time.end:g}: {text}"
            )
        kept = dict(zip(self.times, self.snapshots, strict=True))
        passed = [
            moment
            for moment in sorted({*time.times, time.end})
            if moment <= self.time * (1 + 1e-12)
        ]
        missing = [
            moment
            for moment in passed
            if moment not in kept and abs(moment - self.time) > 1e-12 * moment
        ]
        if missing:
            text = (
                f"{missing[0]:g} s lies before {self.time:g} s, which the "
                "checkpoint has reached, and was not kept"
            )
            raise SceneError(f"{where.at(('time', 'times'))}: time.times: {text}")
        self.times, self.snapshots = (
            passed,
            [kept.get(moment, self.state) for moment in passed],
        )
        return self

    def reactions(self, problem: HeatProblem) -> dict[str, float]:
        """Return the heat that prescribed temperatures have conducted in so far by
        boundary [J].
        """
        names = problem.boundaries
        return dict(
            zip(names, np.broadcast_to(self.reaction, len(names)).tolist(), strict=True)
        )

    @property
    def size(self) -> float | None:
        """Size of the next step of the present ladder [s]; None before the first."""
        return (
            None
            if self.level is None
            else (self.end - self.origin) * 2.0 ** (self.level - LEVELS)
        )

    def climb(self, end: float, size: float | None = None) -> None:
        """Begin another ladder of steps from here to `end` [s], the first not longer
        than `size` [s] if that is given.

        Nothing changes if the present ladder ends there.
        """
        if self.end == end:
            return
        self.origin, self.end, self.tick, self.level = self.time, end, 0, None
        if size is not None:
            self.level = level_of(size, end - self.time)


def run_transient(
    problem: HeatProblem,
    history: History,
    policy: Policy,
    *,
    end: float,
    advance: Callable[[float], None],
    save: Save | None,
    levels: Sequence[int] | None = None,
    enough: Callable[[], bool] | None = None,
) -> History:
    """March `history` to `end` [s]; it always holds the last accepted step, whatever
    happens.

    `levels` are the sizes of all steps of this ladder in a run that is repeated;
    `enough` says after a step whether to stop there.
    """
    time = problem.scene.time
    assert time is not None
    wanted = sorted({*time.times, time.end})
    problem.medium.restore(history.ranges)
    history.climb(end)
    if not history.times and wanted[0] == 0.0:
        _keep(history, 0.0, history.state)
    steps = steps_of(problem, history, policy, end, levels)
    saved = clock.monotonic()
    outlets = Outlets(problem, history.state)
    if problem.linear:  # closures have been evaluated once for all steps
        problem.medium.record()
        history.ranges = problem.medium.state()
    for step in steps:
        after = replace(
            history,
            times=[*history.times],
            snapshots=[*history.snapshots],
            flux={**history.flux},
        )
        for moment in wanted[len(history.times) :]:
            if moment <= step.end * (1 + 1e-12):
                _keep(
                    after,
                    moment,
                    step.states[-1] if moment >= step.end else step.at(moment),
                )
        _account(problem, after, step)
        after.state, after.time = step.states[-1], step.end
        after.tick, after.level = step.tick + 2**step.level, step.next_level
        after.steps += 1
        if not problem.linear:
            problem.medium.record()
            after.ranges = problem.medium.state()
        passed = by_streams(fluxes_of(after), {"": float(np.sum(after.reaction))})
        history.outlet.append((*outlets(step.end, step.states[-1]), *passed))
        # at once, so that an interrupt never leaves half a step
        vars(history).update(vars(after))
        history.levels.append(step.level)
        advance(step.end)
        if save is not None and clock.monotonic() - saved >= time.checkpoint_every:
            save(*history.pack())
            saved = clock.monotonic()
        if enough is not None and enough():
            break
    return history


def steps_of(
    problem: HeatProblem,
    history: History,
    policy: Policy,
    end: float,
    levels: Sequence[int] | None = None,
) -> Iterator[Step]:
    """Return the time steps from the state of `history` to `end` [s]; see `march`."""
    time = problem.scene.time
    assert time is not None
    low, high = problem.T_span
    solver, interval = problem.scene.solver, problem.interval
    # temperatures count from it, intraparticle modes from 0
    uniform = np.zeros(problem.system.size)
    uniform[problem.heats] = low
    return march(
        problem,
        history.state,
        end,
        problem.system.ordered(policy),
        start=history.origin,
        tolerance=time.tolerance,
        span=high - low if high > low else ONE_KELVIN,
        origin=uniform,
        step=time.step,
        tick=history.tick,
        level=history.level,
        newton_options={
            "tolerance": solver.newton_tolerance,
            "iterations": solver.newton_iterations,
            "lower": problem.lower,
            "weights": problem.weights,
        },
        levels=levels,
        sees=None if interval is None else partial(interval.resolves, stages=STAGES),
    )


def enter(
    problem: HeatProblem, history: History, policy: Policy, size: float | None
) -> None:
    """Begin a interval of a run: prescribed temperatures take their values after a jump,
    and give the heat that it takes.

    `size` is the first step [s] where nothing jumps; None for the shortest.
    """
    assert problem.interval is not None
    problem.set_time(problem.interval.start)
    state = np.array(history.state)
    state[problem.fixed] = problem.fixed_values
    state = problem.consistent(state, policy)
    given = problem.content(state, False)[0] - problem.content(history.state, False)[0]
    gain = float(np.sum(given[problem.heats]))
    parts = np.abs(_by_boundary(problem, given[problem.fixed]))
    after = replace(history, state=state, gain=history.gain + gain)
    after.reaction = after.reaction + gain * parts / max(
        float(parts.sum()), np.finfo(float).tiny
    )
    after.climb(problem.interval.end, size)
    vars(history).update(vars(after))


def _by_boundary(problem: HeatProblem, reaction: Any) -> Any:
    return np.array(list(problem.reaction_sums(reaction).values()))


def _keep(history: History, time: float, state: Any) -> None:
    history.times.append(time)
    history.snapshots.append(np.array(state))


def _account(problem: HeatProblem, history: History, step: Any) -> None:
    """Add one step to the balance; the weights are those of the method, so the sums
    close to round-off.
    """
    weights = [weight * step.size for weight in WEIGHTS]
    history.gain += float(np.sum(step.gain[problem.heats]))
    if len(problem.fixed):
        supplied = step.gain + sum(
            w * rate for w, rate in zip(weights, step.rates, strict=True)
        )
        history.reaction = history.reaction + _by_boundary(
            problem, supplied[problem.fixed]
        )
    history.mean = history.mean + sum(
        w * state for w, state in zip(weights, step.states, strict=True)
    )
    if not problem.linear or problem.interval is not None:
        for w, state, share in zip(weights, step.states, STAGES, strict=True):
            problem.set_time(step.start + share * step.size)
            for name, parts in problem.fluxes(state).items():
                for kind, value in parts.items():
                    history.flux[f"{name}.{kind}"] = (
                        history.flux.get(f"{name}.{kind}", 0.0) + w * value
                    )


def by_streams(
    fluxes: dict[str, dict[str, float]], reactions: dict[str, float]
) -> tuple[float, float]:
    """Return the heat into the bed by streams of the fluid, and otherwise [J]."""
    kinds = [pair for parts in fluxes.values() for pair in parts.items()]
    left = sum(value for kind, value in kinds if kind == "T_fluid")
    other = sum(value for kind, value in kinds if kind != "T_fluid")
    return left, other + sum(reactions.values())


def integrated_fluxes(
    problem: HeatProblem, history: History
) -> dict[str, dict[str, float]]:
    """Return the heat through each boundary over the run [J].

    Linear fluxes are those of the mean state times the duration.
    """
    if problem.linear and problem.interval is None:
        fluxes = problem.fluxes(history.mean / history.time)
        return {
            name: {kind: value * history.time for kind, value in parts.items()}
            for name, parts in fluxes.items()
        }
    return fluxes_of(history)


def fluxes_of(history: History) -> dict[str, dict[str, float]]:
    """Return the heat through each boundary so far, where values change [J]."""
    out: dict[str, dict[str, float]] = {}
    for key, value in history.flux.items():
        name, kind = key.rsplit(".", 1)
        out.setdefault(name, {})[kind] = value
    return out
