"""Two-fluid scenes from file to findings: the check cases against what is known
exactly.
"""

from pathlib import Path

import numpy as np
import pytest
from pytest import approx
from scipy.optimize import brentq

import contbed as cb
from contbed import closures
from contbed.models import MODELS
from contbed.two_fluid import run as study
from contbed.two_fluid.averages import spectrum
from tests.balances import assert_closed
from tests.refusals import refused
from tests.restarts import interrupt, same_run
from tests.scene_text import scene_of

STUDY = Path(__file__).parents[2] / "studies" / "two_fluid_checks"


def found(name, **overrides):
    """Named results of a check case."""
    return cb.run(
        cb.load(
            STUDY / f"{name}.toml",
            {key.replace("__", "."): value for key, value in overrides.items()},
        )
    )


def slip(law, scene):
    """Velocity of the gas past particles that drag holds against their weight in
    their own suspension.
    """
    eps, gas, solid = 1.0 - scene.initial.solid.volume_fraction, scene.gas, scene.solid

    def missing(u):
        Re = eps * gas.density * u * solid.diameter / gas.viscosity
        beta = law(Re, eps, solid.diameter, gas.viscosity)
        return beta * u - eps * (1.0 - eps) * (solid.density - gas.density) * 9.81

    return brentq(missing, 1e-6, 10.0, xtol=1e-14)


@pytest.mark.parametrize(
    ("name", "law"),
    [
        ("slip", "drag_wen_yu"),
        ("uniform_wenyu", "drag_wen_yu"),
        ("uniform_syamlal", "drag_syamlal_obrien"),
        ("uniform_gidaspow", "drag_gidaspow"),
    ],
)
def test_gas_passes_a_suspension_at_its_slip_velocity(name, law):
    # implicit drag gives the steady slip at any step (V3, V4)
    result = found(name)
    assert result.qoi["slip_velocity"] == approx(
        slip(closures.get(law), result.plan.scene), rel=1e-8
    )


def test_printed_slip_velocities():
    # shared by several authors for this particle to the digits given
    scene = cb.load(STUDY / "slip.toml")
    assert slip(closures.drag_wen_yu, scene) == approx(1.00303, abs=5e-6)
    assert slip(closures.drag_syamlal_obrien, scene) == approx(0.92414, abs=5e-6)


@pytest.mark.parametrize("shape", ["quadrilateral", "triangle"])
def test_shear_balances_dissipation(shape):
    # a linear velocity and a uniform theta are exact on any grid; 1e-4 is left of the
    # approach in 2 s
    result = found("shear", mesh__cells=[2, 8], mesh__shape=shape)
    assert result.qoi["theta_over_s2d2"] == approx(2.057972, rel=1e-4)


def test_cooling_follows_haff():
    # exact in any step; 2.005229e-5 has seven digits
    qoi = found("cooling", time__step=1e-2, mesh__cells=[2, 2]).qoi
    assert qoi["theta_final"] == approx(2.005229e-5, rel=1e-6)
    # no cell is in the middle fifth of the height
    assert "slip_velocity" not in qoi and np.isfinite(list(qoi.values())).all()


def test_fronts_of_settling():
    # 200 cells of 0.5 mm; the fronts have run 37 and 7.4 mm, a fifth of a cell is
    # allowed
    qoi = found("settling").qoi
    assert qoi["front_position_m"] == approx(0.1 - 8.0 * 4.60966e-3, abs=1e-4)
    assert qoi["lower_front_position_m"] == approx(8.0 * 9.21932e-4, abs=1e-4)
    assert abs(qoi["mass_drift_relative"]) < 1e-14


def test_riemann_problem_of_a_granular_gas():
    # exact: 0.01412995 and 1.18869463; half a cell of 1/400 in 0.36 of way
    qoi = found("riemann", mesh__cells=400).qoi
    assert qoi["eps_star"] == approx(0.01412995, rel=1e-3)
    assert qoi["shock_speed"] == approx(1.18869463, abs=0.0125 / 0.3 * 0.3)


def test_cold_streams_that_meet_lose_nothing():
    result = found("crossing", mesh__cells=100)
    assert abs(result.qoi["mass_drift_relative"]) < 1e-14
    assert result.qoi["eps_s_max"] <= 0.63 * (1 + 1e-12)
    assert result.qoi["max_velocity"] < 1.05


def test_walls_of_johnson_and_jackson_lose_nothing():
    result = found("closed_box_jj", mesh__cells=[7, 25], time__end=0.3)
    assert abs(result.qoi["mass_drift_relative"]) < 1e-14
    assert result.qoi["max_velocity"] > 0.05


def test_probes_show_the_cell_around_them():
    """From s0 to 0 when the front, at 4.60966e-3 m/s, passes, to four cells; points
    outside are told.
    """
    scene = cb.load(
        STUDY / "settling.toml",
        {"output.probes": {"front": [0.0801]}, "time.sample": 0.1},
    )
    result = cb.run(scene)
    t, eps_s = result.profiles["t [s]"], result.profiles["front eps_s [1]"]
    assert t[np.flatnonzero(eps_s < 0.05)[0]] == approx(0.0199 / 4.60966e-3, abs=0.2)
    place = np.flatnonzero(result.tables["axial"]["height [m]"] > 0.0801)[0]
    assert (
        result.profiles["front p [Pa]"][-1] == result.tables["axial"]["p [Pa]"][place]
    )
    refused(
        r"output\.probes\.front.*outside of the mesh(.|\n)*mesh has 1 coord",
        lambda: cb.plan(
            cb.load(
                STUDY / "settling.toml",
                {"output.probes": {"front": [0.2], "two": [0.1, 0.1]}},
            )
        ),
    )


def test_spectrum_finds_a_wave_and_its_power():
    """A sine of amplitude a has the power a^2/2, whole periods to the leakage of the
    window.
    """
    t = np.arange(1000) * 0.01
    frequency, power = spectrum(t, 5.0 + 3.0 * np.sin(2 * np.pi * 4.0 * t))
    assert frequency[np.argmax(power)] == approx(4.0, abs=1e-9)
    assert np.sum(power) * (frequency[1] - frequency[0]) == approx(4.5, rel=1e-3)


def test_restart_is_bit_for_bit(tmp_path):
    change = {
        "mesh.cells": [4, 20],
        "time.end": 0.05,
        "time.sample": 0.01,
        "time.average_from": 0.02,
        "output.probes": {"low": [0.1, 0.1]},
    }
    scene = cb.load(STUDY / "closed_box_jj.toml", change)
    interrupt(scene, tmp_path, study, "_keep", 4)
    same_run(cb.run(scene, tmp_path, restart=tmp_path), cb.run(scene))


def test_a_later_end_keeps_the_rows(tmp_path):
    """A run that stops at 10 ms has rows every 0.05 ms; resumed twice, to 12 and 14 ms,
    it is the run to 14 ms with these rows, to the last bit.
    """
    first = {"mesh.cells": [4, 20], "time.end": 0.01}
    later = {**first, "time.end": 0.014}
    cb.run(cb.load(STUDY / "closed_box_jj.toml", first), tmp_path)
    cb.run(
        cb.load(STUDY / "closed_box_jj.toml", {**first, "time.end": 0.012}),
        tmp_path,
        restart=tmp_path,
    )
    found = cb.run(
        cb.load(STUDY / "closed_box_jj.toml", later), tmp_path, restart=tmp_path
    )
    whole = cb.load(STUDY / "closed_box_jj.toml", {**later, "time.sample": 5e-5})
    same_run(found, cb.run(whole))


def test_a_bed_at_rest_stays_in_a_closed_box():
    """Gas of the empty cell above and particles of the full one below meet on the faces
    between, 1.6 in all.

    Such faces let volume through against the pressure, until the equation of pressure
    was singular.
    """
    scene = cb.load(
        MODELS["two_fluid"].template,
        scene_of(
            """
                time = { end = 0.2, sample = 0.05 }
                output = { plots = false, fields = false }

                [mesh]
                type = "rectangle"
                length = 0.02
                height = 0.06
                cells = [4, 12]

                [initial]
                solids = { beads = { granular_temperature = 1e-4 } }
                layer = [{ end = 0.024, solids = { beads = { volume_fraction = 0.58 } } }]
            """,
            {
                "boundary": {
                    name: {"type": "wall"}
                    for name in ("left", "right", "bottom", "top")
                }
            },
        ),
    )
    result = cb.run(scene)
    # the surface is spread over one cell of 5 mm, which lifts the centre by 0.3 mm
    assert result.profiles["centre_of_solids [m]"] == approx(0.0125, abs=5e-4)
    assert 0.5 < result.qoi["eps_s_max"] < 0.63
    assert_closed(result, 1e-14, "solids")
