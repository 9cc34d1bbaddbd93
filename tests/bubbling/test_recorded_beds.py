"""Recorded Jacobians of bubbling beds against those by dual numbers, at random
states of all beds of the studies.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bubbling_scenes import case1
from computed_scenes import hot

import contbed as cb
from contbed.bubbling_bed.equations import bed
from contbed.bubbling_bed.plan import plan
from contbed.bubbling_bed.problem import RECORDED_FROM, BubblingProblem

STUDIES = Path(__file__).parents[2] / "studies"
SCENES = {
    str(path.relative_to(STUDIES).with_suffix("")): path
    for path in sorted(STUDIES.glob("*/[a-z]*.toml"))
    if "\n[bubbling_bed]\n" in path.read_text(encoding="utf-8")
}
SPREAD = 0.05  # relative, of the random states


def problem_of(scene: Any) -> BubblingProblem:
    return BubblingProblem(plan(scene))


def random_state(problem: BubblingProblem, seed: int) -> Any:
    x = problem._start(problem.plan.scene.initial.temperature)
    rng = np.random.default_rng(seed)
    return problem._state(x * (1.0 + SPREAD * rng.uniform(-1.0, 1.0, len(x))))


def compare(problem: BubblingProblem, state: Any) -> None:
    """Both to rounding: of the largest term in a row, as the terms of a derivative
    are added in another order.
    """
    with np.errstate(all="ignore"):
        residual, matrix = problem.system.assemble(problem.forms, state)
        found, jacobian = problem.assemble(state, True)
    np.testing.assert_allclose(
        found, residual, rtol=0, atol=1e-14 * np.abs(residual).max()
    )
    rows = abs(matrix).max(axis=1).toarray().ravel()
    assert (abs(jacobian - matrix).max(axis=1).toarray().ravel() <= 1e-13 * rows).all()


@pytest.mark.parametrize("name", SCENES)
def test_beds_of_the_studies(name: str) -> None:
    problem = problem_of(cb.load(SCENES[name]))
    problem._record_from = 1
    for seed in range(2):
        compare(problem, random_state(problem, seed))
    assert problem._recorded is not None and not problem.unrecorded


def test_studies_are_found() -> None:
    assert len(SCENES) >= 14


@pytest.mark.parametrize("smoothed", [1.0, 0.01])
def test_rounded_edges_are_recorded_anew(smoothed: float) -> None:
    """A recording holds for one set of coefficients."""
    problem = problem_of(hot())
    problem._record_from = 1
    compare(problem, random_state(problem, 0))
    seen = []

    def newton(x: Any) -> Any:
        if problem.c.computed.smoothed in (smoothed, 1e-3):
            compare(problem, problem._state(x))
            seen.append(problem.c.computed.smoothed)
        return x, []

    problem.solve_near = newton  # type: ignore[method-assign]
    problem._unbent(problem.unknowns(random_state(problem, 1)))
    assert seen == [smoothed, 1e-3]
    compare(problem, random_state(problem, 0))


def test_other_coefficients_are_recorded_anew() -> None:
    problem = problem_of(case1())
    state = random_state(problem, 0)
    for _ in range(RECORDED_FROM):
        compare(problem, state)
    other = problem.with_scene(problem_of(case1(distributor=None)).plan.scene)
    assert problem._recorded is not None and other._recorded is None


def test_same_steady_state_by_dual_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """A form that asks for values is told, and solved with dual numbers."""
    recorded = cb.run(case1(), quiet=True)
    assert not any("dual numbers" in text for text in recorded.warnings)
    gas_entry = bed.gas_entry

    def asking(u: Any, c: Any) -> Any:
        assert np.any(u.T_emulsion > 0.0)
        return gas_entry(u, c)

    monkeypatch.setattr(bed, "gas_entry", asking)
    by_dual = cb.run(case1(), quiet=True)
    assert any(text.endswith("numpy.any is not recorded") for text in by_dual.warnings)
    assert by_dual.qoi == pytest.approx(recorded.qoi, rel=1e-9)
