"""One file of a fixed bed, run by the packed bed and by two fluids whose particles
are at rest.
"""

from pathlib import Path

import numpy as np
import pytest

import contbed as cb
from contbed.errors import SceneError
from contbed.loading import loads
from contbed.many.compare import compare

BED = """
[mesh]
type = "line"
length = 0.1

[gas]
density = 60.0
viscosity = 1.8e-5
heat_capacity = 1005.0
conductivity = 0.026

[solids.beads]
diameter = "2 mm"
density = 2500.0
heat_capacity = 840.0
conductivity = 1.0

[closures]
nusselt = "nusselt_gunn"
conductivity_gas = 0.0            # two fluids conduct nothing unless told so
conductivity_solids = 0.0

[heat]

[boundary.left]
type = "inlet"
gas.velocity = 0.1                # a third of that of minimum fluidization
gas.temperature = 400.0

[boundary.right]
type = "outlet"

[initial]
gas = { temperature = 300.0, velocity = 0.25 }
solids.beads = { temperature = 300.0, volume_fraction = 0.6 }

[time]
end = 10.0

[packed_bed]
porosity = 0.4

[two_fluid]
gravity = 9.81
"""
SPAN = 100.0  # [K] between the gas that enters and the bed at the start


def run(model, **changes):
    """Result of the bed by a model."""
    keys = {"model": model} | {
        name.replace("__", "."): value for name, value in changes.items()
    }
    return cb.run(loads(BED, overrides=keys))


@pytest.fixture(scope="module")
def packed():
    """Positions and temperatures of gas and particles at the end, by the packed bed
    on its own mesh.
    """
    found = run("packed_bed").profiles
    last = found["t [s]"] == found["t [s]"].max()
    return [found[name][last] for name in ("x [m]", "T_fluid [K]", "T_solid [K]")]


def difference(cells, packed):
    """Largest difference of both temperatures between the models, over the span."""
    result = run("two_fluid", mesh__cells=cells, time__longest=0.05)
    # the weight of a packing that settles by a thousandth of a diameter
    assert result.qoi["max_velocity"] < 1e-4
    found = result.tables["axial"]
    x, T_gas, T_solid = packed
    gas = found["T_gas [K]"] - np.interp(found["height [m]"], x, T_gas)
    solid = found["T_solid [K]"] - np.interp(found["height [m]"], x, T_solid)
    return max(np.abs(gas).max(), np.abs(solid).max()) / SPAN


@pytest.mark.slow
def test_a_fixed_bed_has_the_same_temperatures_by_both_models(packed):
    """The difference is the error of the cells of the two fluids, which falls with
    their size.
    """
    coarse, fine = difference(20, packed), difference(50, packed)
    assert fine < 4e-3
    assert coarse / fine > 1.5


PAGE = Path(__file__).parents[2] / "docs" / "howto" / "compare.md"
SETTLING = 0.01  # of the pressure drop: the beads have settled after two seconds


def test_the_bed_of_the_manual_is_the_same_by_three_models(tmp_path, capsys):
    """Packed bed, two fluids at rest and a bubbling bed below fluidization, in a bed
    that has the temperature of the gas: only rounding and the solvers' tolerances
    are left.
    """
    file = tmp_path / "bed.toml"
    text = PAGE.read_text(encoding="utf-8").partition("```toml\n")[2]
    file.write_text(text.partition("```")[0].replace("350 K", "400 K"))
    models = ["packed_bed", "two_fluid", "bubbling_bed"]
    found = compare(file, models, tmp_path / "out", {"time.end": 2.0}, quiet=False)
    begun = [line for line in capsys.readouterr().err.splitlines() if ": run" in line]
    assert begun == [f"{name}: run {k} of 3" for k, name in enumerate(models, 1)]
    packed, fluids, bubbling = (outcome.results for outcome in found.outcomes)
    assert [outcome.problem for outcome in found.outcomes] == ["", "", ""]
    for name in ("T_gas_mean", "T_solids_mean"):
        values = [each[name].value for each in (packed, fluids, bubbling)]
        assert values == pytest.approx([400.0] * 3, abs=1e-6)
    assert bubbling["T_gas_out"].value == pytest.approx(packed["T_gas_out"].value)
    # Ergun's law in both; constant properties are those at 400 K
    drop = packed["pressure_drop"].value
    assert fluids["pressure_drop"].value == pytest.approx(drop, rel=SETTLING)


BETWEEN_PLATES = """
[mesh]
type = "rectangle"
length = "20 mm"
height = "5 mm"
cells = [20, 2]

[gas]
density = 1.1
viscosity = 1.9e-5
heat_capacity = 1006.0
conductivity = 0.028

[solids.glass]
diameter = "0.5 mm"
density = 2500.0
heat_capacity = 840.0
conductivity = 1.0

[closures]
nusselt = "nusselt_gunn"
conductivity_gas = 0.0            # of the packed bed
conductivity_solids = 0.2

[heat]

[boundary.left]
type = "wall"
temperature = 353.15

[boundary.right]
type = "wall"
temperature = 293.15

[boundary.bottom]
type = "wall"

[boundary.top]
type = "wall"

[initial]
gas.temperature = 293.15
solids.glass = { temperature = 293.15, volume_fraction = 0.6 }

[time]
end = 120.0
longest = 0.5                     # step of two fluids

[packed_bed]
porosity = 0.4

[two_fluid]
conductivity_solids = 0.333333333 # times the solids fraction: that of the packed bed
"""


def test_a_bed_between_plates_by_two_models(tmp_path):
    """Walls with a temperature: one file, and the series of a slab, within 0.1 % of
    the rise of its mean and 1 % of its heat, which two fluids take from a wall law.
    """
    (tmp_path / "bed.toml").write_text(BETWEEN_PLATES, encoding="utf-8")
    models = ["packed_bed", "two_fluid"]
    made = compare(tmp_path / "bed.toml", models, tmp_path / "runs").outcomes
    capacity = 0.6 * 2500.0 * 840.0 + 0.4 * 1.1 * 1006.0
    n = np.arange(1, 60, 2)
    decay = np.exp(-((n * np.pi / 0.02) ** 2) * 0.2 / capacity * 120.0)
    mean = 293.15 + 60.0 * (0.5 - np.sum(4.0 / (n * np.pi) ** 2 * decay))
    for outcome in made:
        assert not outcome.problem
        assert outcome.results["heat_left"].unit == "W/m"
        found = outcome.results["T_solids_mean"].value
        assert found == pytest.approx(mean, abs=1e-3 * (mean - 293.15))
        taken = sum(outcome.results[f"heat_{side}"].value for side in ("left", "right"))
        # per metre of depth, in the mean over the run
        rise = capacity * 0.02 * 0.005 * (mean - 293.15) / 120.0
        assert taken == pytest.approx(rise, rel=1e-2)


def test_means_of_a_round_bed_are_those_of_its_volume():
    """The particles gained the heat of the hot wall, to 2e-3 of it: gas, whose share of
    the capacity is 4e-4, counts with them, and the balance of the run; the mean along
    the axis is 26 K lower.
    """
    mesh = {"type": "axisymmetric", "radius": 0.02, "length": 0.005, "cells": [20, 2]}
    round_bed = BETWEEN_PLATES.replace("boundary.left", "boundary.wall")
    text = round_bed.replace(
        '[boundary.right]\ntype = "wall"\ntemperature = 293.15', ""
    )
    found = cb.run(loads(text, overrides={"model": "packed_bed", "mesh": mesh})).qoi
    capacity = (0.6 * 2500.0 * 840.0 + 0.4 * 1.1 * 1006.0) * np.pi * 0.02**2 * 0.005
    rise = found["heat_wall_W"] * 120.0 / capacity
    assert found["T_solid_mean_K"] == pytest.approx(293.15 + rise, abs=2e-3 * rise)
    assert found["T_fluid_mean_K"] == pytest.approx(found["T_solid_mean_K"], abs=0.01)


def test_a_wall_acts_on_the_phase_that_conducts():
    """The gas of the packed bed conducts nothing, which is no reason to warn; that
    nothing conducts is.
    """

    def is_idle(**changes):
        keys = {"model": "packed_bed"} | changes
        found = cb.run(loads(BETWEEN_PLATES, overrides=keys)).warnings
        return sum("boundary.left.temperature has no effect" in text for text in found)

    assert not is_idle()
    assert is_idle(**{"closures.conductivity_solids": 0.0}) == 1


def test_a_phase_that_neither_conducts_nor_exchanges_is_undetermined():
    """Walls give a steady temperature to what conducts it alone."""
    steady = BETWEEN_PLATES.split("[initial]")[0]
    keys = {"model": "packed_bed", "closures.nusselt": 0.0}
    with pytest.raises(SceneError, match="temperature of the gas is undetermined"):
        loads(steady, overrides=keys)


def test_particles_that_leave_carry_no_heat_of_a_wall():
    """The gas is at rest: the only wall is the one that heats."""
    moving = loads(
        BETWEEN_PLATES,
        overrides={
            "model": "packed_bed",
            "boundary.bottom.solids.glass": {"velocity": 1e-4, "temperature": 293.15},
        },
    )
    found = cb.run(moving).qoi
    assert found["heat_left_W"] > 0.0
    assert "heat_top_W" not in found and "heat_bottom_W" not in found


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"boundary.left.type": "inlet"}, "gas.temperature is that of a stream"),
        ({"boundary.left.type": "symmetry"}, "no heat passes a plane of symmetry"),
        ({"boundary.left.gas.heat_flux": 1.0}, "not in both"),
        ({"boundary.left.heat_flux": 1.0}, "temperature, coefficient or heat_flux"),
        (
            {
                "mesh": {"type": "line", "length": 0.02, "diameter": 0.1},
                "boundary.wall.temperature": 300.0,
            },
            r"boundary\.wall\.temperature = 300.0: only heat passes through the side",
        ),
    ],
)
def test_walls_have_one_condition_of_the_whole_bed(changes, text):
    """A temperature that both phases take stands alone, and at walls."""
    with pytest.raises(SceneError, match=text):
        loads(BETWEEN_PLATES, overrides={"model": "packed_bed"} | changes)
