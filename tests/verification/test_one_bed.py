"""One file of a fixed bed, run by the packed bed and by two fluids whose particles
are at rest.
"""

import numpy as np
import pytest

import contbed as cb
from contbed.loading import loads

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


def test_a_fixed_bed_has_the_same_temperatures_by_both_models(packed):
    """The difference is the error of the cells of the two fluids, which falls with
    their size.
    """
    coarse, fine = difference(20, packed), difference(50, packed)
    assert fine < 4e-3
    assert coarse / fine > 1.5
