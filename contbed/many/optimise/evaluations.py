"""Runs of a design: each scene and each gradient is computed once and kept by the hash
of the scene.

`runs/NAME/` is that of a sweep; `gradients.jsonl` holds the derivatives of results by
the keys that were asked for. A run or gradient that is there is taken from there, so
that a killed command resumes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import ContbedError, SceneError
from contbed.many.derivatives.differences import seeds, with_seeds
from contbed.many.derivatives.gradients import gradient
from contbed.many.optimise.constrained_search import EvaluationFailed
from contbed.many.optimise.problem import Design, plain
from contbed.many.quantities import number_of
from contbed.many.runs import Case, case_of, compute, known
from contbed.many.store import Store, key_of

TEXT = 2  # exit code of a scene that contradicts itself


class OutOfRuns(Exception):
    """As many runs as the design allows are computed."""


@dataclass
class Evaluation:
    """One point: its keys (keys,), run and outcome, values of objective and constraints
    if it has them.

    functions : what is minimised, then the excess of each constraint,
        (1 + constraints,); None if the run failed
    each : the same of every run, if the design repeats them, (runs, 1 + constraints);
        all else are their means
    """

    point: Array
    run: str
    qoi: Mapping[str, Any]
    exit_code: int
    problem: str
    functions: Array | None
    differentiated: bool = False
    each: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def values(self) -> Array:
        """What is minimised and the excess of each constraint."""
        if self.functions is None:
            raise EvaluationFailed(self.problem)
        return self.functions


def named_values(
    design: Design, point: Array, qoi: Mapping[str, Any]
) -> dict[str, float]:
    """Return the keys and results that expressions may use, by name."""
    return design.values_at(point) | {name: float(qoi[name]) for name in design.results}


@dataclass
class Evaluations:
    """All points of a design in the order in which they were first asked for."""

    design: Design
    folder: Path
    retry_failed: bool = False
    found: dict[bytes, Evaluation] = field(default_factory=dict)
    before: int = 0
    method: str = ""
    standard_errors: bool = False
    told: Any = None  # called with each new evaluation
    gradients: Store = field(init=False)

    def __post_init__(self) -> None:
        self.gradients = Store(self.folder / "gradients.jsonl")

    def at(self, point: Array) -> Evaluation:
        """Return the evaluation at a point.

        Raises
        ------
        OutOfRuns : it is new and no run is left
        """
        rounded = np.array(
            [
                plain(key, float(v))
                for key, v in zip(self.design.keys, point, strict=True)
            ],
            dtype=float,
        )
        mark = rounded.tobytes()
        if mark not in self.found:
            if len(self.found) >= self.design.runs:
                raise OutOfRuns
            self.found[mark] = self._computed(rounded)
            if self.told is not None:
                self.told(self)
        return self.found[mark]

    @property
    def rows(self) -> tuple[Evaluation, ...]:
        """All evaluations in order."""
        return tuple(self.found.values())

    def _computed(self, point: Array) -> Evaluation:
        try:
            cases = self._repeated(self._case(point))
        except SceneError as error:
            return Evaluation(point, "", {}, TEXT, "; ".join(error.problems), None)
        outcomes = [self._outcome(case) for case in cases]
        there = [outcome["qoi"] for outcome in outcomes if not outcome["exit_code"]]
        if not there:
            return Evaluation(
                point,
                cases[0].name,
                {},
                outcomes[0]["exit_code"],
                outcomes[0]["problem"],
                None,
            )
        found = Evaluation(
            point,
            cases[0].name,
            there[0] if len(there) == 1 else _means(there),
            0,
            "",
            None,
        )
        self._fill(found, there)
        return found

    def _repeated(self, case: Case) -> list[Case]:
        """Return a case with as many seeds as the design repeats it."""
        places = seeds(case.scene)
        others = (
            with_seeds(case.scene, places, k) for k in range(1, self.design.repeats)
        )
        return [case, *(case_of(scene, case.parameters) for scene in others)]

    def _outcome(self, case: Case) -> dict[str, Any]:
        """Return the outcome of a run, computed or kept."""
        outcome = known(case, self.folder, self.retry_failed)
        self.before += outcome is not None
        return outcome or compute(case, self.folder)

    def _case(self, point: Array) -> Case:
        scene = self.design.scene_at(point)
        parameters = {
            key.name: float(value)
            for key, value in zip(self.design.keys, point, strict=True)
        }
        return case_of(scene, parameters)

    def _fill(self, found: Evaluation, runs: Sequence[Mapping[str, Any]]) -> None:
        """Fill in objective and constraints by the results of all runs of a point,
        or why there are none.
        """
        missing = [
            name
            for name in self.design.results
            if not isinstance(found.qoi.get(name), int | float)
        ]
        if missing:
            if not self.found:
                number_of(found.qoi, missing[0], self._place(missing[0]))
            found.problem = f"the run has no result {', '.join(missing)}"
            return
        found.each = np.array([self._functions(found.point, qoi) for qoi in runs])
        functions = found.each.mean(axis=0)
        if np.isfinite(functions).all():
            found.functions = functions
        else:
            texts = [
                self.design.objective.text,
                *(one.text for one in self.design.constraints),
            ]
            bad = ", ".join(
                text
                for text, value in zip(texts, functions, strict=True)
                if not np.isfinite(value)
            )
            found.problem = f"{bad}: not a finite number"

    def _functions(self, point: Array, qoi: Mapping[str, Any]) -> list[float]:
        """Return what is minimised and the excess of each constraint by the results
        of one run.
        """
        values = named_values(self.design, point, qoi)
        return [
            self.design.sign * self.design.objective(values),
            *(one.excess(values) for one in self.design.constraints),
        ]

    def _place(self, name: str) -> str:
        """Return where the design asks for a result."""
        if name in self.design.objective.names:
            return self.design.objective_at
        return next(one.at for one in self.design.constraints if name in one.names)

    def derivatives(self, point: Array, keys: Sequence[int]) -> Array:
        """Return the derivatives of objective and constraints to some of the keys,
        (1 + constraints, keys).

        Raises
        ------
        EvaluationFailed : the run or its gradient failed
        SceneError : a key has no derivative
        """
        at = self.at(point)
        at.values  # noqa: B018 - raises where the run has failed
        names = [self.design.keys[k].name for k in keys]
        slopes = {name: np.zeros(len(keys)) for name in self.design.fixed()}
        slopes |= {
            name: np.array([float(name == other) for other in names])
            for name in (key.name for key in self.design.keys)
        }
        if self.design.results:
            slopes |= self._gradient(at, names)
        values = named_values(self.design, at.point, at.qoi)
        parts = [one.derivatives(values) for one in self.design.constraints]
        rows = [
            {
                name: self.design.sign * slope
                for name, slope in self.design.objective.derivatives(values).items()
            },
            *parts,
        ]
        at.differentiated = True
        return np.array(
            [
                np.sum([slope * slopes[name] for name, slope in row.items()], axis=0)
                + np.zeros(len(keys))
                for row in rows
            ]
        )

    def _gradient(self, at: Evaluation, names: Sequence[str]) -> dict[str, Array]:
        """Return the derivatives of each result to the keys `names`, computed or
        kept.
        """
        results = list(self.design.results)
        case = self._case(at.point)

        def compute_gradient() -> dict[str, Any]:
            try:
                found = gradient(case.scene, results, names)
            except ContbedError as error:
                if isinstance(error, SceneError) and not any(
                    row.differentiated for row in self.rows
                ):
                    raise  # a key without derivative, not a point without one
                raise EvaluationFailed(f"no gradient: {error}") from error
            return {
                "derivatives": found.derivatives,
                "standard_errors": found.standard_errors,
                "method": found.method,
            }

        kept = self.gradients.kept(
            key_of(case.name, results, list(names)), compute_gradient
        )
        self.method = kept["method"]
        self.standard_errors |= kept["standard_errors"] is not None
        return dict(
            zip(results, np.array(kept["derivatives"], dtype=float), strict=True)
        )


def _means(runs: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the means of the numbers that all runs have."""
    numbers = [
        name for name, value in runs[0].items() if isinstance(value, int | float)
    ]
    return {
        name: float(np.mean([run[name] for run in runs]))
        for name in numbers
        if all(isinstance(run.get(name), int | float) for run in runs)
    }


@dataclass
class Slice:
    """Objective and constraints over some of the keys, the others held: what a search
    by gradients minimises.

    chosen : numbers of the keys that change
    held : a point (keys,) with the values of the others
    """

    evaluations: Evaluations
    chosen: list[int]
    held: Array

    def __post_init__(self) -> None:
        design = self.evaluations.design
        self.low, self.high = design.low[self.chosen], design.high[self.chosen]
        self.equality = design.equality

    def point(self, x: Array) -> Array:
        """Return all keys (keys,) where those chosen have the values x."""
        whole = self.held.copy()
        whole[self.chosen] = x
        return whole

    def values(self, x: Array) -> Array:
        """Return objective and constraints, (1 + constraints,)."""
        return self.evaluations.at(self.point(x)).values

    def derivatives(self, x: Array) -> Array:
        """Return their derivatives, (1 + constraints, chosen)."""
        return self.evaluations.derivatives(self.point(x), self.chosen)
