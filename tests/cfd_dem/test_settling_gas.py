"""Beds of particles in a gas settle in their run: not for a plan, not again for a restart, not for a large trial."""

import numpy as np
import pytest

import contbed as cb
from contbed.cfd_dem.plan import APART, LONGEST_TRIED, MOST_TRIED
from contbed.errors import SceneError
from contbed.loading import loads
from contbed.trial import _predict
from tests.cfd_dem.test_probes import SCENE

LARGE = SCENE.replace("count = 60", "count = 30000").replace('"8 mm", "8 mm"', '"80 mm", "20 mm"')


@pytest.fixture
def never(monkeypatch):
    def settled(*arguments, **options):
        raise AssertionError("settles")

    monkeypatch.setattr("contbed.cfd_dem.plan.pack", settled)


def test_a_plan_does_not_settle(never):
    plan = cb.plan(loads(SCENE))
    assert plan.particles is None and plan.unknowns()["particles"] == 360
    assert "60, settled from a random start, moving" in str(plan)
    assert "particles: 360 unknowns, about 1 MB" in str(plan) and "heat:" not in str(plan)


def test_a_restart_does_not_settle_again(tmp_path, monkeypatch):
    scenes = [loads(SCENE.replace("end = 0.004", f"end = {end}")) for end in (0.002, 0.004)]
    whole = cb.run(scenes[1])
    cb.run(scenes[0], out=tmp_path)
    monkeypatch.setattr("contbed.cfd_dem.plan.pack", None)
    found = cb.run(scenes[1], restart=tmp_path)
    assert found.qoi == whole.qoi
    assert len(found.plan.particles) == 60


def test_a_bed_higher_than_the_box_is_told_by_the_run(tmp_path):
    with pytest.raises(SceneError, match=r"gas.height: centres from .* the box from 0 to 0.005 m"):
        cb.run(loads(SCENE.replace('height = "60 mm"', 'height = "5 mm", cell = [1, 1]').split("output")[0]), tmp_path)


def test_a_trial_of_many_particles_starts_from_a_lattice(never):
    """They do not overlap, lie in the box, and fill it as a settled bed does, within the looser packing."""
    plan = cb.plan(loads(LARGE))
    lattice, settling = plan.to_try()
    assert MOST_TRIED < 30000 and 60.0 < settling < 240.0  # s
    x, radius, width = lattice.particles.position, 1e-3, (0.08, 0.02)
    assert x.min() >= radius and (x[:, :2].max(axis=0) <= np.array(width) - radius).all()
    assert len({tuple(np.rint(row / (2 * APART * radius) - 0.5).astype(int)) for row in x}) == 30000
    spacing = np.diff(np.unique(np.round(x[:, 2], 9)))
    assert spacing == pytest.approx(2 * APART * radius, rel=1e-5)
    solids = 30000 * 4 / 3 * np.pi * radius**3 / (width[0] * width[1] * (x[:, 2].max() + radius))
    assert 0.45 < solids < 0.53


def test_time_of_a_large_bed_is_predicted_without_settling_it(never):
    plan = cb.plan(loads(LARGE.split("output")[0]))
    seconds, settling = _predict(plan, plan.scene.time.end)[0], plan.to_try()[1]
    assert settling < seconds < settling + 60.0


def test_a_trial_of_few_stiff_particles_starts_from_a_lattice(never):
    """60 particles of 1e15 Pa take 24,000 times the steps of those of 1 MPa to settle."""
    found, settling = cb.plan(loads(SCENE.replace("1 MPa", "1e15 Pa"))).to_try()
    assert len(found.particles) == 60 and settling > LONGEST_TRIED


def test_stiffer_particles_settle_in_more_and_shorter_steps():
    soft, stiff = (cb.plan(loads(LARGE.replace('"1 MPa"', f'"{text}"'))).to_try()[1] for text in ("1 MPa", "10 MPa"))
    # a tenth more modulus to the power of 2.5 is one more stage, of steps 10^0.4 shorter
    assert stiff / soft == pytest.approx(1.0 + 0.13 / 0.6 * 10**0.4, rel=1e-3)


@pytest.mark.parametrize(
    ("cell", "axes"), [("[0.1, 0.1]", ["width", "height"]), ("[3, 0.5]", ["height"]), ("[1, 1]", [])]
)
def test_cells_smaller_than_particles_are_told(cell, axes):
    told = loads(SCENE.replace('"60 mm"', f'"60 mm", cell = {cell}')).warnings
    assert [text.partition(": ")[2].split()[3] for text in told if "needs several particles" in text] == axes
