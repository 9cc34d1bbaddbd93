"""What `contbed plan` tells of the time of steady reacting beds: by a trial and the iterations that are expected."""

from __future__ import annotations

import pytest
from reacting_bed_scenes import danckwerts, ignition

import contbed as cb
from contbed import trial
from contbed.loading import from_dict
from contbed.models import plan
from contbed.reacting_bed import solve
from studies.clc_moving_bed import study as clc
from studies.dri_shaft import study as dri
from studies.reformer_tube import study as reformer

BEDS = [
    pytest.param(reformer.HERE / f"{reformer.CASES[0]}.toml", False, id="tube"),
    pytest.param(clc.HERE / "iron_oxide.toml", False, id="moving bed"),
    *(
        pytest.param(dri.HERE / f"{name}.toml", True, id=name, marks=pytest.mark.slow)
        for name in ("h2_5m", "natural_gas", "two_sizes")
    ),
]


@pytest.mark.parametrize(("file", "helped"), BEDS)
def test_as_many_iterations_as_expected(file, helped):
    """Within a factor of 2, the promise of the plan, of iterations times cells, which is what takes time."""
    shares = []
    report = solve.Report(tell=shares.append)
    solve.steady(plan(cb.load(file)).problem, report)
    assert report.helped == helped
    assert 0.5 < report.work / (solve.EXPECTED[helped, True] * solve.FIRST_CELLS) < 2.0
    assert 0.0 < shares[0] < 0.1 and max(shares) <= solve.LAST_SHARE


def test_given_cells_take_fewer():
    scene = danckwerts(10.0, 1.0)
    scene["mesh"]["cells"] = 7
    shares = []
    report = solve.Report(tell=shares.append)
    solve.steady(plan(from_dict(scene)).problem, report)
    assert shares[0] == pytest.approx(1.0 / solve.EXPECTED[False, False])
    assert report.work == 7.0 * len(shares)


def test_the_plan_tells_the_time_of_a_steady_bed(monkeypatch):
    planned = plan(from_dict(danckwerts(10.0, 1.0)))
    assert trial.predicted_time(planned).endswith(" s of processor, by a trial")
    monkeypatch.setattr(trial, "SEARCH_BUDGET", 0.0)
    assert trial.predicted_time(planned).endswith(" of processor, by the first 0 s of a trial")


def test_a_branch_ends_the_trial_too(monkeypatch):
    scene = ignition(10.0, 10.0, 0.6, 10.0, 0.1)
    scene["continuation"] = {"parameter": "reactions.r.factor", "to": 0.2}
    planned, told = plan(from_dict(scene)), []

    def spent():
        """No time until the branch, and then much."""
        return 100.0 * bool(told)

    from contbed.reacting_bed import branch

    before = branch.follow
    monkeypatch.setattr(trial.clock, "process_time", spent)
    monkeypatch.setattr(branch, "follow", lambda *given: told.append(1) or before(*given))
    assert trial.predicted_time(planned).endswith(
        "by the first 5 s of a trial; the branch over [continuation] comes on top"
    )
