"""Beds of particles in a gas settle in their run: not for a plan, not again for a
restart.
"""

import numpy as np
import pytest

import contbed as cb
from contbed.cfd_dem.plan import _wrapped
from contbed.errors import SceneError
from contbed.loading import loads
from contbed.materials.constants import fluid_of
from tests.cfd_dem.test_probes import SCENE
from tests.refusals import refused


@pytest.fixture
def never(monkeypatch):
    def settled(*arguments, **options):
        raise AssertionError("settles")

    monkeypatch.setattr("contbed.cfd_dem.plan.pack", settled)


def test_a_plan_does_not_settle(never):
    plan = cb.plan(loads(SCENE))
    assert plan.particles is None and plan.unknowns()["particles"] == 360
    assert "60, settled from a random start, moving" in str(plan)
    assert "particles: 360 unknowns, about 1 MB" in str(plan) and "heat:" not in str(
        plan
    )


def test_a_restart_does_not_settle_again(tmp_path, monkeypatch):
    scenes = [
        loads(SCENE.replace("end = 0.004", f"end = {end}")) for end in (0.002, 0.004)
    ]
    whole = cb.run(scenes[1])
    cb.run(scenes[0], out=tmp_path)
    monkeypatch.setattr("contbed.cfd_dem.plan.pack", None)
    found = cb.run(scenes[1], restart=tmp_path)
    assert found.qoi == whole.qoi
    assert len(found.plan.particles) == 60


def test_a_bed_higher_than_the_box_is_told_by_the_run(tmp_path):
    refused(
        r"particles.height: centres from .* the box from 0 to 0.005 m",
        lambda: cb.run(
            loads(
                SCENE.replace(
                    'height = "60 mm"', 'height = "5 mm", cell = [1, 1]'
                ).split("output")[0]
            ),
            tmp_path,
        ),
    )


def test_former_keys_name_the_present_ones():
    text = """[particles]
count = 60
radius = 1e-3
[fluid]
density = 1.2
[gas]
velocity = 1.0
jet = { slot = [0.0, 0.1], T = 300.0 }
[heat]
T = 300.0
"""
    with pytest.raises(SceneError) as error:
        loads(text)
    for told in (
        "scene.toml:3: particles.radius = 0.001: solids.NAME.diameter takes the place "
        "of a radius",
        "scene.toml:4: fluid: this key is called 'gas' now",
        "scene.toml:7: gas.velocity = 1.0: this key is called "
        "'boundary.bottom.gas.velocity' now",
        "scene.toml:8: gas.jet.slot = [0.0, 0.1]: boundary.jet.start and "
        "boundary.jet.end take its place",
        "scene.toml:10: heat.T = 300.0: this key is called "
        "'initial.solids.NAME.temperature' now",
    ):
        assert told in str(error.value)


@pytest.mark.parametrize(
    ("gas", "density"),
    [
        (
            "density = 1.2, viscosity = 1.8e-5, heat_capacity = 1005.0, conductivity = "
            "0.026",
            1.2,
        ),
        ('composition = "N2:0.79, O2:0.21"', 1.17197),
        ('model = "coolprop", name = "Air", T_range = [250, 400]', 1.1769),
    ],
)
def test_a_gas_by_constants_composition_or_name(gas, density):
    """Density of air at 300 K and 1 atm: an ideal gas of 28.85 g/mol, and Lemmon et
    al. 2000 to four digits.
    """
    constants = (
        "density = 1.2, viscosity = 1.8e-5, heat_capacity = 1005.0, "
        "conductivity = 0.026"
    )
    scene = loads(SCENE.replace(constants, gas))
    assert float(fluid_of(scene.gas, scene.origin).density(300.0)) == pytest.approx(
        density, rel=1e-4
    )


def test_a_start_temperature_belongs_to_an_energy_equation():
    start = "initial.solids.glass.temperature = 300.0\n"
    refused(
        r"initial\.solids\.glass\.temperature.* no use without a \[heat\] table",
        lambda: loads(SCENE + start),
    )
    refused(
        r"initial\.solids\.glass\.temperature: missing",
        lambda: loads(SCENE + "heat = {}\n"),
    )
    refused(
        r"initial\.solids\.sand: no such solid phase",
        lambda: loads(SCENE + start.replace("glass", "sand")),
    )


@pytest.mark.parametrize(
    ("cell", "axes"),
    [("[0.1, 0.1]", ["width", "height"]), ("[3, 0.5]", ["height"]), ("[1, 1]", [])],
)
def test_cells_smaller_than_particles_are_told(cell, axes):
    told = loads(SCENE.replace('"60 mm"', f'"60 mm", cell = {cell}')).warnings
    assert [
        text.partition(": ")[2].split()[3]
        for text in told
        if "needs several particles" in text
    ] == axes


def test_centres_beyond_a_periodic_side_enter_by_the_other():
    """Those less than a radius beyond; others are refused as in a box with walls."""
    scene = loads(SCENE.replace("count = 60", "count = 60, periodic = true"))
    table = scene.particles
    width, radius = table.width[0], scene.solid.radius
    x = np.array([[-1e-9, 0.0, 0.0], [width + 1e-9, 0.0, 0.0], [-2.0 * radius, 0, 0]])
    found = _wrapped(x, radius, table)
    assert found[:, 0] == pytest.approx([width, 0.0, -2.0 * radius], abs=2e-9)
    assert found[0, 0] <= width and found[1, 0] >= 0.0
    walls = table.model_copy(update={"periodic": False})
    assert _wrapped(x, radius, walls) is x
