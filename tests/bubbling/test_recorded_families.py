"""Weak forms recorded once over a value of the scene, against those of each value by
dual numbers.
"""

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
    """A family after as many Jacobians as it takes to record, a state away from the
    solution, and the value there.
    """
    problem = BubblingProblem(plan(scene))
    x = problem._start(scene.initial.temperature)
    x *= 1.0 + 0.02 * np.random.default_rng(6).uniform(-1.0, 1.0, len(x))
    family, value = Family(problem, key), float(value_at(scene, key))
    for _ in range(RECORDED_FROM):
        family.assemble(x, value, True)
    return family, x, value


def compare(family: Family, x: Any, value: float) -> None:
    """Rounding of the largest term in a row, as in `test_recorded_beds`; of a march
    through bubbles 1.5e-13.
    """
    with np.errstate(all="ignore"):
        residual, matrix = family.at(value).steady(x, True)
        found, jacobian = family.assemble(x, value, True)
        again, none = family.assemble(x, value, False)
    terms = abs(matrix) @ np.abs(x)
    assert (np.abs(found - residual) <= 1e-14 * terms).all()
    np.testing.assert_array_equal(again, found)
    assert none is None
    rows = abs(matrix).max(axis=1).toarray().ravel()
    assert (abs(jacobian - matrix).max(axis=1).toarray().ravel() <= 3e-13 * rows).all()


@pytest.mark.parametrize(
    "scene, key",
    [
        (lambda: cb.load(BOILER), "bubbling_bed.tubes.perimeter"),
        (case1, "bubbling_bed.tubes.perimeter"),
        (case1, "boundary.bottom.gas.temperature"),
        (case1, "bubbling_bed.section"),
        (case1, "bubbling_bed.tubes.temperature"),
        pytest.param(
            lambda: cb.load(BOILER),
            "boundary.bottom.gas.mass_flow",
            marks=pytest.mark.slow,
        ),
        (hot, "boundary.bottom.gas.mass_flow"),
    ],
)
def test_any_value_after_one_recording(scene: Any, key: str) -> None:
    family, x, value = family_of(scene(), key)
    recorded = family.recorded
    assert recorded is not None
    for factor in (1.0, 0.7, 1.9, 1.0):
        compare(family, x, factor * value)
    assert family.recorded is recorded
    moved = (
        family.assemble(x, 1.1 * value, False)[0] - family.assemble(x, value, False)[0]
    )
    assert np.abs(moved).max() > 0.0


def test_coefficients_that_ask_for_the_value_are_made_anew() -> None:
    """A release of none is left out."""
    family, x, value = family_of(case1(), "solids.char.release.rate")
    assert family.recorded is None
    compare(family, x, 1.05 * value)


def test_recordings_that_hold_for_one_value_are_not_used(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Coefficients that put the first value in the place of the parameter: right
    there, wrong at any other.
    """
    at, first = Family.at, float(value_at(case1(), "bubbling_bed.tubes.perimeter"))

    def kept(family: Family, p: Any) -> BubblingProblem:
        return at(family, p if isinstance(p, float) else first)

    monkeypatch.setattr(Family, "at", kept)
    family, x, value = family_of(case1(), "bubbling_bed.tubes.perimeter")
    assert value == first and family.recorded is None
    compare(family, x, value)
