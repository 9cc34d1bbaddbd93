"""Weak forms recorded once over a value of the scene, against those of each value by dual numbers."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bubbling_scenes import case1
from computed_scenes import hot

import contbed as cb
from contbed.bubbling_bed.branch import Family
from contbed.bubbling_bed.plan import plan
from contbed.bubbling_bed.problem import RECORDED_FROM, BubblingProblem
from contbed.scene.values import value_at

BOILER = Path(__file__).parents[2] / "studies" / "boiler_optimum" / "boiler.toml"


def family_of(scene: Any, key: str) -> tuple[Family, Any, float]:
    """A family after as many Jacobians as it takes to record, a state away from the solution, and the value there."""
    problem = BubblingProblem(plan(scene))
    x = problem._start(scene.solver.guess)
    x *= 1.0 + 0.02 * np.random.default_rng(6).uniform(-1.0, 1.0, len(x))
    family, value = Family(problem, key), float(value_at(scene, key))
    for _ in range(RECORDED_FROM):
        family.assemble(x, value, True)
    return family, x, value


def compare(family: Family, x: Any, value: float) -> None:
    """Rounding of the largest term in a row, as in `test_recorded_beds`."""
    with np.errstate(all="ignore"):
        residual, matrix = family.at(value).steady(x, True)
        found, jacobian = family.assemble(x, value, True)
        again, none = family.assemble(x, value, False)
    terms = abs(matrix) @ np.abs(x)
    assert (np.abs(found - residual) <= 1e-14 * terms).all()
    np.testing.assert_array_equal(again, found)
    assert none is None
    rows = abs(matrix).max(axis=1).toarray().ravel()
    assert (abs(jacobian - matrix).max(axis=1).toarray().ravel() <= 1e-13 * rows).all()


@pytest.mark.parametrize(
    "scene, key",
    [
        (lambda: cb.load(BOILER), "tubes.perimeter"),
        (case1, "tubes.perimeter"),
        (case1, "gas.temperature"),
        (case1, "bubbling_bed.section"),
    ],
)
def test_any_value_after_one_recording(scene: Any, key: str) -> None:
    family, x, value = family_of(scene(), key)
    recorded = family.recorded
    assert recorded is not None
    for factor in (1.0, 0.7, 1.9, 1.0):
        compare(family, x, factor * value)
    assert family.recorded is recorded
    moved = family.assemble(x, 1.1 * value, False)[0] - family.assemble(x, value, False)[0]
    assert np.abs(moved).max() > 0.0


@pytest.mark.parametrize("scene, key", [(hot, "gas.mass_flow"), (case1, "species.char.release.rate")])
def test_coefficients_that_ask_for_the_value_are_made_anew(scene: Any, key: str) -> None:
    """The bubbles march up with a flow that is a number; a release of none is left out."""
    family, x, value = family_of(scene(), key)
    assert family.recorded is None
    compare(family, x, 1.05 * value)


def test_recordings_with_another_residual_are_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coefficients that put a number of their own in the place of the parameter hold for one value only."""
    at = Family.at

    def kept(family: Family, p: Any) -> BubblingProblem:
        return at(family, p if isinstance(p, float) else 100.0)

    monkeypatch.setattr(Family, "at", kept)
    family, x, value = family_of(case1(), "tubes.perimeter")
    assert value != 100.0 and family.recorded is None
    compare(family, x, value)
