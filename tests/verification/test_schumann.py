"""The closed form of a bed without conduction whose phases start apart, and its heat."""

import numpy as np
import pytest

import contbed
from contbed.loading import loads
from contbed.packed_bed.schumann import Schumann

CELLS = 500
WHEAT = """
[mesh]
type = "line"
length = 4.0
[gas]
density = 1.22
viscosity = 1.8e-5
heat_capacity = 1006.0
conductivity = 0.025
[solids.wheat]
diameter = 3.8e-3
density = 1300.0
heat_capacity = 1900.0
conductivity = 0.15
[packed_bed]
porosity = 0.4
[closures]
nusselt = "wakao_kaguei"
conductivity_gas = 0.0
conductivity_solids = 0.0
[heat]
[boundary.left]
gas.velocity = 0.1
gas.temperature = "10 degC"
[initial]
temperature = "25 degC"
[time]
end = "14.7633328 h"
times = ["12.0790904 h", "13.4212116 h"]
[output]
positions = [4.0]
"""


def marched(bed, steps):
    """Return places, and temperatures of parcels that move by a cell in each step
    between half steps of exchange, of second order in the cell.
    """
    C_f, C_s = bed.capacity_fluid, bed.capacity_solid
    dt = bed.length / CELLS / bed.velocity
    half = -np.expm1(-0.5 * dt * bed.exchange * (1.0 / C_f + 1.0 / C_s)) / (C_f + C_s)
    fluid, solid = np.full(CELLS, bed.fluid), np.full(CELLS, bed.solid)
    for _ in range(steps):
        for move in (True, False):
            passed = half * (solid - fluid)
            fluid, solid = fluid + C_s * passed, solid - C_f * passed
            if move:
                fluid = np.concatenate(([bed.inlet], fluid[:-1]))
    z = (np.arange(CELLS) + 0.5) * bed.length / CELLS
    return z, dt * steps, fluid, solid


@pytest.mark.parametrize("share", [0.4, 1.3])
@pytest.mark.parametrize("C_f", [0.4, 3e3], ids=["gas", "liquid"])
def test_phases_that_start_apart(C_f, share):
    """Before and after what fills the bed has left: cells of a 50th of a transfer unit err
    by some tenths of its square, 3e-5 of 300 K, the front by its cell.
    """
    bed = Schumann(1.0, 0.5, C_f, 2e3, 5.0 * C_f, inlet=600.0, fluid=500.0, solid=300.0)
    z, time, fluid, solid = marched(bed, int(share * CELLS))
    T_fluid, T_solid = bed.at(z, time)
    sharp = np.abs(z - bed.velocity * time) < 2.0 / CELLS
    assert np.abs(T_fluid - fluid)[~sharp].max() < 0.01
    assert np.abs(T_solid - solid)[~sharp].max() < 0.01
    heat = bed.heat(time)
    # rounding of integrals
    assert heat["in"] - heat["out"] == pytest.approx(heat["stored"], rel=1e-11)


def test_a_long_bed_of_many_transfer_units():
    """Wheat that is aerated, NTU 1816: J(x, y) by quadrature of its definition, to the
    digits that are written.
    """
    found = contbed.run(loads(WHEAT))
    T_fluid = found.profiles["T_fluid [K]"]
    assert T_fluid == pytest.approx([298.135, 290.600, 283.174], abs=6e-4)
    assert abs(found.balances["energy"]["relative_residual"]) < 1e-12
    # straight lines between the times that are written, a thousandth of the run apart
    outlet = found.tables["outlet"]
    hours = np.array([12.0790904, 13.4212116, 14.7633328])
    between = np.interp(3600.0 * hours, outlet["t [s]"], outlet["T_fluid_out [K]"])
    assert between == pytest.approx(T_fluid, abs=1e-9)
    assert len(outlet["t [s]"]) > 1000


ROCKS = """
mesh = { type = "line", length = 3.0 }
gas = { density = 1.0, viscosity = 2.1e-5, heat_capacity = 1008.0, conductivity = 0.03 }
packed_bed.porosity = 0.42
heat = {}
closures = { nusselt = 50.0, conductivity_gas = 0.0, conductivity_solids = K }
initial.temperature = "20 degC"
time.end = "1.75 h"
[solids.rock]
diameter = 0.04
density = 2600.0
heat_capacity = 850.0
conductivity = 2.5
[boundary.left.gas]
velocity = 0.3
temperature = "120 degC"
"""


def test_a_store_has_the_results_of_one_that_hardly_conducts():
    """Pressure drop, heat, exergy and thermocline: a conductivity of 1e-3 W/m/K changes
    them by less than the error of 1e-4 of its steps, and that of straight lines between
    the places of a thermocline.
    """
    closed, solved = (
        contbed.run(loads(ROCKS.replace("K }", f"{k} }}"))).qoi for k in ("0.0", "1e-3")
    )
    for name in (
        "pressure_drop_Pa",
        "T_fluid_out_K",
        "heat_charged_J",
        "heat_stored_J",
        "effectiveness_charge",
        "exergy_charged_J",
        "storage_capacity_J",
        "utilisation",
        "thermocline_m",
    ):
        assert closed[name] == pytest.approx(solved[name], rel=1e-3), name
    assert closed["heat_lost_J"] == 0.0
