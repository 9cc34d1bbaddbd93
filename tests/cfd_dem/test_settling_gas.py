"""Beds of particles in a gas settle in their run: not for a plan, not again for a restart."""

import pytest

import contbed as cb
from contbed.errors import SceneError
from contbed.loading import loads
from tests.cfd_dem.test_probes import SCENE


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


@pytest.mark.parametrize(
    ("cell", "axes"), [("[0.1, 0.1]", ["width", "height"]), ("[3, 0.5]", ["height"]), ("[1, 1]", [])]
)
def test_cells_smaller_than_particles_are_told(cell, axes):
    told = loads(SCENE.replace('"60 mm"', f'"60 mm", cell = {cell}')).warnings
    assert [text.partition(": ")[2].split()[3] for text in told if "needs several particles" in text] == axes
