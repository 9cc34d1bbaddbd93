"""The predictions of all experiments as a function of the scaled keys; runs are kept
and computed on several cores.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Protocol

import numpy as np

from contbed.arrays import Array
from contbed.errors import SceneError, interrupt_in
from contbed.many.calibrate.experiments import Job, Point
from contbed.many.calibrate.observe import observe
from contbed.many.calibrate.settings import FittedKey
from contbed.many.runs import DIED, KILLED, failure
from contbed.many.store import Content, Store, key_of
from contbed.many.value_sets import tidy
from contbed.many.workers import computed
from contbed.result import Result
from contbed.scene.identity import scene_hash
from contbed.scene.tables import SceneBase


class Model(Protocol):
    """What a fit needs to know of a model."""

    def values(self, z: Array) -> Array:
        """Return the predictions, shape (sets, points), for sets of scaled keys,
        shape (sets, keys); nan if failed.
        """
        ...

    def slopes(self, z: Array) -> Array | None:
        """Return derivatives of the predictions, shape (points, keys), at one set of
        scaled keys; None if unknown.
        """
        ...


class SceneModel:
    """The runs of the jobs of a calibration.

    Attributes
    ----------
    points : what is predicted, in the order of the predictions
    computed : runs that were computed by this process
    """

    def __init__(
        self,
        keys: Sequence[FittedKey],
        jobs: Sequence[Job],
        store: Store,
        processes: int = 1,
    ):
        self._keys, self._jobs, self._store, self._processes = (
            tuple(keys),
            tuple(jobs),
            store,
            processes,
        )
        self.points: tuple[Point, ...] = tuple(
            point for job in jobs for point in job.points
        )
        self.computed = 0
        self._has_tangents = True  # until a run says otherwise

    def at(self, z: Array) -> dict[str, float]:
        """Return the keys in SI at one set of scaled keys, shape (keys,)."""
        return {
            key.name: tidy(float(key.prior.value(float(each))))
            for key, each in zip(self._keys, z, strict=True)
        }

    def values(self, z: Array) -> Array:
        """Return the predictions, shape (sets, points), for sets of scaled keys, shape
        (sets, keys).

        A run that fails leaves not-a-numbers in its points and is kept with its
        problem.
        """
        names: list[list[str]] = []
        waiting: dict[str, tuple[SceneBase, Job]] = {}
        for one in z:
            keys, row = self.at(one), []
            for job in self._jobs:
                try:
                    scene = job.load(keys)
                except SceneError as error:
                    name = _name([str(job.scene), keys], job)
                    if self._store.known(name) is None:
                        self._store.add(name, _failed(error, keys))
                else:
                    name = _name(scene_hash(scene), job)
                    if self._store.known(name) is None:
                        waiting.setdefault(name, (scene, job))
                row.append(name)
            names.append(row)
        for name, outcome in self._found(waiting):
            self.computed += 1
            scene = waiting[name][0]
            self._store.add(
                name,
                outcome
                | ({"scene": scene_hash(scene)} if outcome["exit_code"] else {}),
            )
        return np.array([[value for name, job in zip(row, self._jobs, strict=True) for value in self._of(name, job)]
                         for row in names])  # fmt: skip

    def slopes(self, z: Array) -> Array | None:
        """Return the derivatives with respect to scaled keys, shape (points, keys), by
        the tangents of the runs.

        None where a prediction is not a named result of a scene that has a tangent, or
        a run failed.
        """
        if not self._has_tangents or any(point.in_profiles for point in self.points):
            return None
        keys = self.at(z)
        try:
            scenes = [job.load(keys) for job in self._jobs]
        except SceneError:
            return None
        names = [
            _name(f"{scene_hash(scene)} slopes", job)
            for scene, job in zip(scenes, self._jobs, strict=True)
        ]
        missing = {
            name: (scene, job)
            for name, scene, job in zip(names, scenes, self._jobs, strict=True)
            if self._store.known(name) is None
        }
        for name, outcome in self._found(missing, tuple(keys)):
            self.computed += 1
            self._store.add(name, outcome)
        outcomes = [self._store.known(name) or {} for name in names]
        rows = [row for outcome in outcomes for row in outcome.get("slopes") or [None]]
        self._has_tangents = all(
            outcome.get("slopes") is not None or outcome["exit_code"]
            for outcome in outcomes
        )
        if any(row is None for row in rows):
            return None
        scale = [
            key.prior.slope(float(at)) for key, at in zip(self._keys, z, strict=True)
        ]
        return np.asarray(np.array(rows) * np.array(scale))

    def _of(self, name: str, job: Job) -> list[float]:
        outcome = self._store.known(name)
        assert outcome is not None, "all runs have ended"
        if outcome["exit_code"]:
            return [np.nan] * len(job.points)
        return [np.nan if value is None else value for value in outcome["values"]]

    def problem(self) -> str:
        """Return why the last run that failed did so."""
        failed = self._store.failed()
        return str(failed[-1]["problem"]) if failed else ""

    def _found(
        self, waiting: dict[str, tuple[SceneBase, Job]], keys: tuple[str, ...] = ()
    ) -> Iterator[tuple[str, Content]]:
        """Yield the outcomes of runs, or of derivatives to keys; a process that dies
        takes one run with it.
        """
        found = computed(
            _outcome,
            [(name, scene, job, keys) for name, (scene, job) in waiting.items()],
            self._processes,
            begun=lambda task: True,
            lost=lambda task: {"exit_code": KILLED, "problem": DIED},
        )
        for (name, *_), outcome in found:
            yield name, outcome


def _name(scene: Any, job: Job) -> str:
    """Return the key of a run with what is wanted of it."""
    return key_of(
        scene, [[point.quantity, repr(point.t), repr(point.x)] for point in job.points]
    )


def _outcome(_: str, scene: SceneBase, job: Job, keys: tuple[str, ...]) -> Content:
    from contbed.runner import run

    try:
        result = run(scene)
        if keys:
            slopes = _slopes(result, job, keys)
            return {"exit_code": 0, "problem": "", "slopes": slopes}
    except Exception as error:  # one broken run must not lose the others
        if interrupt_in(error) is not None:
            raise
        return _failed(error, {})
    return {"exit_code": 0, "problem": "", "values": observe(result, job.points)}


def _slopes(
    result: Result, job: Job, keys: tuple[str, ...]
) -> list[list[float]] | None:
    """Return derivatives in SI, (points, keys); None where the physics has no
    tangent.
    """
    from contbed.many.derivatives import tangent
    from contbed.many.derivatives.gradients import gradient_of

    if tangent.of(result) is None:
        return None
    found = gradient_of(result, [point.quantity for point in job.points], keys)
    return [[float(value) for value in row] for row in found.derivatives]


def _failed(error: Exception, keys: dict[str, float]) -> Content:
    code, problem = failure(error)
    values = ", ".join(f"{name} = {value:.6g}" for name, value in keys.items())
    return {
        "exit_code": code,
        "problem": f"{problem} (with {values})" if values else problem,
    }
