"""Outlet temperatures of a transient packed bed at every step: the end of its
profiles, kept through a restart.
"""

import numpy as np
import pytest

import contbed as cb
from contbed.loading import loads

BED = """
mesh = { type = "line", length = 0.5, cells = 40 }
gas = { density = 1.0, heat_capacity = 1000.0, conductivity = 0.03, viscosity = 2e-5 }
solids.particles = { density = 2000.0, heat_capacity = 800.0, conductivity = 0.5, diameter = "5 mm" }
packed_bed = { porosity = 0.4 }
closures = { nusselt = "wakao_kaguei" }
heat = {}
initial = { gas.temperature = 300.0, solids.particles.temperature = 300.0 }
[boundary.INLET]
gas = { velocity = 0.5, temperature = 600.0 }
[time]
end = 600.0
tolerance = 1e-4
"""


def scene(text=BED, inlet="left"):
    return loads(text.replace("INLET", inlet))


@pytest.mark.parametrize(("inlet", "end"), [("left", -1), ("right", 0)])
def test_every_step_has_a_row_and_the_last_is_the_end_of_the_profile(inlet, end):
    result = cb.run(scene(inlet=inlet))
    table = result.tables["outlet"]
    assert list(table) == ["t [s]", "T_fluid_out [K]"]  # particles at rest do not leave
    assert (
        len(table["t [s]"]) == result.qoi["time_steps"]
        and (np.diff(table["t [s]"]) > 0.0).all()
    )
    assert (
        table["T_fluid_out [K]"][-1]
        == result.qoi["T_fluid_out_K"]
        == result.profiles["T_fluid [K]"][end]
    )


def test_the_heat_that_leaves_is_that_of_the_outlet():
    """Trapezoids of the outlet above the inlet's 600 K against the balance; their
    error is that of the steps, 1e-3.
    """
    result = cb.run(scene())
    t, T = result.tables["outlet"].values()
    t, T = np.concatenate([[0.0], t]), np.concatenate([[300.0], T])
    leaving = 0.5 * 1.0 * 1000.0 * float(np.sum(0.5 * (T[1:] + T[:-1]) * np.diff(t)))
    entering = 0.5 * 1.0 * 1000.0 * 600.0 * 600.0
    assert entering - leaving == pytest.approx(
        result.balances["energy"]["stored"], rel=1e-3
    )


def test_a_plane_has_the_outlet_of_its_line():
    """A stream across the whole side: the mean over the facets is the temperature of
    the line to rounding.
    """
    plane = BED.replace(
        'type = "line", length = 0.5, cells = 40',
        'type = "rectangle", length = 0.5, height = 0.1',
    )
    plane = (
        plane.replace("height = 0.1", "height = 0.1, cells = [40, 2]")
        + "\n[solver]\nreduce = false\n"
    )
    line, wide = cb.run(scene()).tables["outlet"], cb.run(scene(plane)).tables["outlet"]
    np.testing.assert_allclose(
        wide["T_fluid_out [K]"], line["T_fluid_out [K]"], atol=1e-8
    )


def test_rows_before_a_restart_are_kept(tmp_path):
    whole = cb.run(scene())
    part = scene(BED.replace("end = 600.0", "end = 200.0"))
    cb.run(part, out=tmp_path / "part")
    longer = cb.run(scene(), out=tmp_path / "whole", restart=tmp_path / "part")
    reached = cb.run(part).tables["outlet"]["t [s]"]
    table = longer.tables["outlet"]
    # but for the step that was cut short to meet the end
    np.testing.assert_array_equal(table["t [s]"][: len(reached) - 1], reached[:-1])
    assert table["t [s]"][-1] == whole.tables["outlet"]["t [s]"][-1] == 600.0
    assert (
        (tmp_path / "whole" / "outlet.csv")
        .read_text()
        .startswith("t [s],T_fluid_out [K]\n")
    )
