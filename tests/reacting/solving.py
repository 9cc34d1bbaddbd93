"""Runs of reacting beds whose balances close, and steps of one length."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import contbed
from contbed.loading import from_dict
from contbed.models import plan
from contbed.reacting_bed.course import Course
from contbed.reacting_bed.history import BedHistory
from contbed.reacting_bed.solve import Report
from contbed.reacting_bed.stages import stages
from contbed.reacting_bed.time_steps import BedSteps, begin
from contbed.result import Result
from tests.balances import assert_closed

CLOSED = 1e-12  # of what enters


def course_of(scene: dict[str, Any]) -> Course:
    """The course of a run over time that has not begun."""
    built: Any = plan(from_dict(scene))
    return Course.of(built.scene, built.problem, built.schedule, built.stores_gas)


def solved(scene: dict[str, Any]) -> Result:
    """Result of a run, all of whose balances close."""
    result = contbed.run(from_dict(scene))
    assert_closed(result, CLOSED)
    return result


def marched(course: Course) -> Iterator[BedHistory]:
    """Histories after the steps of a run."""
    return BedSteps(course, Report()).march(begin(course, course.start()))


def stepped(scene: dict[str, Any], dt: float) -> dict[str, np.ndarray]:
    """Unknowns by name after three steps in time of one length [s]."""
    course = course_of(scene)
    u = course.start()
    for _ in range(3):
        _, u, _ = stages(
            (course.problem, course.problem), u, u, dt, Report(), course.sizes(u)
        )
    return dict(zip(course.problem.names, u, strict=True))
