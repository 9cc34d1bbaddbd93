"""Effectiveness, transfer units and pinch of moving beds against closed forms."""

from math import exp

from pytest import approx

import contbed as cb
from contbed.loading import loads
from contbed.packed_bed.of_heaters import transfer_units

# 1 m; the fluid carries 500 W/m2/K, the particles 1000; h a L gives the transfer units
HEATER = """
mesh = { type = "line", length = 1.0 }
gas = { density = 1.0, heat_capacity = 1000.0, conductivity = 1.0, viscosity = 2e-5 }
solids.grains = { density = 2000.0, heat_capacity = 500.0, conductivity = 1.0, diameter = "6 mm" }
packed_bed = { porosity = 0.4 }
closures = { nusselt = NUSSELT, conductivity_gas = 0.0, conductivity_solids = 0.0 }
heat = {}
boundary.left.gas = { velocity = 0.5, temperature = 300.0 }
boundary.SIDE.solids.grains = { velocity = VELOCITY, temperature = 500.0 }
"""
JACKET = "boundary.right.solids.grains = { coefficient = 50.0, ambient = 400.0 }\n"
AREA = 6.0 * 0.6 / 0.006  # of the particles over the volume of the bed


def heater(units, side, velocity="1e-3", bed=HEATER):
    """A bed of so many transfer units of its weaker stream, the fluid."""
    nusselt = units * 500.0 / AREA * 0.006
    text = bed.replace("NUSSELT", repr(nusselt)).replace("SIDE", side)
    return cb.run(loads(text.replace("VELOCITY", velocity))).qoi


def test_a_counter_current_heater_is_that_of_the_handbook():
    q = heater(3.0, "right")
    fall = exp(-3.0 * (1.0 - 0.5))
    share = (1.0 - fall) / (1.0 - 0.5 * fall)
    assert q["effectiveness"] == approx(share, rel=1e-5)
    assert q["NTU"] == approx(3.0, rel=1e-4)
    # the particles enter 200 K hotter; the fluid, which carries less, meets them there
    assert q["pinch_K"] == approx(200.0 * (1.0 - share), rel=1e-3)
    assert q["pinch_m"] == 1.0


def test_streams_that_a_jacket_heats_have_no_transfer_units():
    """Neither what they exchange is their duty, nor is it bounded by their inlets."""
    conducts = HEATER.replace("solids = 0.0", "solids = 1.0")
    q = heater(3.0, "left", bed=conducts + JACKET)
    assert "pinch_K" in q and not {"effectiveness", "NTU"} & q.keys()


def test_equal_streams_have_one_difference_of_temperatures():
    q = heater(3.0, "right", "0.5e-3")
    assert q["effectiveness"] == approx(0.75, rel=1e-5)
    assert q["NTU"] == approx(3.0, rel=1e-4)
    assert q["pinch_K"] == approx(50.0, rel=1e-4)


def test_a_co_current_heater_is_that_of_the_handbook():
    q = heater(1.2, "left")
    share = (1.0 - exp(-1.2 * 1.5)) / 1.5
    assert q["effectiveness"] == approx(share, rel=1e-5)
    assert q["NTU"] == approx(1.2, rel=1e-4)
    assert q["pinch_K"] == approx(200.0 * exp(-1.2 * 1.5), rel=1e-4)


def test_no_exchanger_is_better_than_the_best():
    assert transfer_units(1.0, 0.5, True) is None
    assert transfer_units(0.7, 0.5, False) is None


def test_streams_that_cross_have_no_transfer_units_of_parallel_ones():
    text = HEATER.replace("NUSSELT", "0.02").replace(
        '"line", length = 1.0',
        '"rectangle", length = 1.0, height = 1.0, cells = [8, 8]',
    )
    text = text.replace("boundary.left.gas", "boundary.bottom.gas")
    q = cb.run(loads(text.replace("SIDE", "left").replace("VELOCITY", "1e-3"))).qoi
    assert 0.0 < q["effectiveness"] < 1.0 and "NTU" not in q
