"""Breakthrough, mass-transfer zone and what cycles separate, against closed forms."""

from types import SimpleNamespace

import numpy as np
import pytest
from adsorption_scenes import DENSITY, EPS, SPEED, TRACE, adsorber, constant_pattern
from pytest import approx
from reacting_bed_scenes import MOLAR, R_GAS
from solving import solved

from contbed.loading import loads
from contbed.particle.uptake import breakthrough
from contbed.reacting_bed.of_columns import narrow_zones
from tests.scene_text import set_keys

LEVELS = np.array([1.0, 5.0, 50.0, 95.0])


def found_times(qoi):
    return [qoi[f"breakthrough_{level:g}_A_s"] for level in LEVELS]


def test_a_straight_isotherm_breaks_through_as_its_closed_form():
    units, K = 20.0, 200.0
    scene, unit = adsorber(K, units, 0.1)
    set_keys(scene, 'solids.particles.inside = { adsorption = "interior" }')
    scene["time"] |= {"end": 45.0 * unit, "tolerance": 1e-4}
    set_keys(scene, "mesh.cells = 12")
    qoi = solved(scene).qoi
    eta = np.linspace(1.0, 45.0, 4401)
    curve = breakthrough(units, eta, 0.1, "interior")
    times = np.interp(0.01 * LEVELS, curve, eta) * unit
    assert found_times(qoi) == approx(times, rel=2e-3)
    zone = (times[3] - times[1]) / times[2]  # of 1 m
    assert qoi["mass_transfer_zone_A_m"] == approx(zone, rel=5e-3)
    kept = np.concatenate([[1.0], 1.0 + np.cumsum(0.01 * (1.0 - curve[1:]))])
    used, whole = np.interp(times[[1, 3]] / unit, eta, kept)
    assert qoi["capacity_used_A"] == approx(used / whole, rel=3e-3)


@pytest.mark.parametrize("K", [40.0, 400.0])
def test_gas_in_the_voids_that_is_left_out_is_told(K):
    """The front comes early by the residence of the gas, EPS/SPEED for 1 m: EPS over
    0.6 K of the time of a straight isotherm, 1.7 % and 0.17 %.
    """
    delay, times = EPS / SPEED, []
    scene, _ = adsorber(K, 20.0, 1.0)
    set_keys(scene, 'solids.particles.inside = { adsorption = "film" }')
    scene["time"] |= {"end": 130.0 * delay * K / 40.0, "tolerance": 1e-3}
    set_keys(scene, "mesh.cells = 10")
    for storage in ("auto", "stored"):
        set_keys(scene, f'packed_bed.gas_storage = "{storage}"')
        result = solved(scene)
        times.append(result.qoi["breakthrough_50_A_s"])
        told = [text for text in result.warnings if "give packed_bed.gas_st" in text]
        expected = storage == "auto" and K < 100.0
        assert len(told) == int(expected)
        if expected:
            assert f"{delay:.3g} s early" in told[0]
    assert times[1] - times[0] == approx(delay, rel=0.1)


def test_a_langmuir_front_has_the_length_of_its_constant_pattern():
    units, capacity = 12.0, 1.25
    scene, unit = adsorber(200.0, units, 1.0, capacity)
    set_keys(scene, 'solids.particles.inside = { adsorption = "film" }')
    scene["time"] |= {"end": 1.7 * units * unit, "tolerance": 1e-3}
    set_keys(scene, "mesh.cells = 6")
    qoi = solved(scene).qoi
    r = 1.0 - 1.0 / capacity
    times = (units + constant_pattern(0.01 * LEVELS[1:], r)) * unit
    assert found_times(qoi)[1:] == approx(times, rel=2e-3)
    zone = (times[2] - times[0]) / times[1]  # of 1 m
    assert qoi["mass_transfer_zone_A_m"] == approx(zone, rel=1e-2)
    assert "purity_A" not in qoi


def test_a_run_that_ends_early_has_the_levels_that_it_reached():
    scene, unit = adsorber(200.0, 12.0, 1.0, 1.25)
    set_keys(scene, 'solids.particles.inside = { adsorption = "film" }')
    scene["time"] |= {"end": 10.0 * unit, "tolerance": 1e-2}
    set_keys(scene, "mesh.cells = 6")
    qoi = solved(scene).qoi
    assert "breakthrough_5_A_s" in qoi and "breakthrough_95_A_s" not in qoi
    assert "mass_transfer_zone_A_m" not in qoi


def test_a_cycle_of_a_bed_that_takes_up_next_to_nothing():
    """What leaves is what enters: all of A in the first third of the cycle, N purest in
    the rest of it.
    """
    scene, _ = adsorber(1e-4, 5.0, 1.0)
    set_keys(scene, 'solids.particles.inside = { adsorption = "film" }')
    feed = ["A:1e-6, N:0.999999", "N:1"]
    scene["boundary"]["left"]["gas"]["composition"] = {
        "times": [0.0, 100.0],
        "values": feed,
        "form": "step",
    }
    set_keys(
        scene,
        """
        time.end = 300.0
        time.tolerance = 1e-3
        time.cycle = {}
        mesh.cells = 4
        """,
    )
    qoi = solved(scene).qoi
    assert qoi["purity_A"] == approx(TRACE, rel=1e-4)
    assert qoi["recovery_A"] == approx(1.0, rel=1e-4)
    assert qoi["purity_N"] == approx(1.0, rel=1e-9)
    assert qoi["recovery_N"] == approx(2.0 / 3.0, rel=1e-5)
    moles = 100.0 * SPEED * MOLAR * TRACE
    mass = (1.0 - EPS) * DENSITY
    expected = moles / (mass * 300.0)
    assert qoi["productivity_A_mol_kgs"] == approx(expected, rel=1e-4)


GUARD = """
mesh = { type = "line", length = "1 m", cells = 8 }
packed_bed = { porosity = 0.4, pressure_drop = "none" }
gas.model = "ideal_gas"
gas.composition = "G:1e-4, N2:0.9999"
gas.pressure = "1 bar"
gas.species.G = { elements = { O = 1 }, molar_mass = 0.03 }
gas.species.N2 = {}
boundary.left.gas = { molar_flux = 2.0, temperature = 400.0 }
initial.gas.composition = "N2:1"
output = { plots = false, fields = false }

[solids.pellets]
diameter = "3 mm"
density = 1000.0
composition = "A:1"
constituent.A = { elements = { Fe = 1 }, molar_mass = 0.05 }
constituent.B = { elements = { Fe = 1, O = 1 }, molar_mass = 0.08 }
"""


def at_rest(text, end, equation, rate, k):
    """Results of solids at rest that react at a rate per volume of the bed."""
    scene = loads(
        f"""{text}
        [time]
        end = "{end}"
        tolerance = 1e-4
        [reactions.r]
        equation = "{equation}"
        rate = "{rate}"
        parameters.k = "{k}"
        basis = "bed"
        """
    )
    return solved(scene).qoi


def test_a_guard_bed_breaks_through_when_its_solid_is_used_up():
    """A rate k c n of a trace: exp(T)/(exp(T) + exp(X) - 1) of what enters leaves, T = k
    c_0 t and X = k n_0 L/u (Bohart, Adams 1920, doi:10.1021/ja01448a018).
    """
    qoi = at_rest(GUARD, "1.8e8 s", "A + G -> B", "k*c_G*n_A", "1e-5 m**3/mol/s")
    moles = 1e5 / (R_GAS * 400.0)
    X = 1e-5 * 0.6 * 1000.0 / 0.05 * moles / 2.0
    shares = np.array([0.5, 0.95])
    times = np.log(np.expm1(X) * shares / (1.0 - shares)) / (1e-5 * 1e-4 * moles)
    found = [qoi["breakthrough_50_G_s"], qoi["breakthrough_95_G_s"]]
    assert found == approx(times, rel=1e-3)
    assert qoi["conversion_A"] > 0.9


def test_a_rate_that_does_not_know_its_solid_ends_with_it():
    """Of first order in the gas alone: a front of 1/10 of the bed moves as fast as the
    gas uses up the solid, v = u c_0/n_0, from the time at which that of the inlet is
    gone, n_0/(k c_0), and c = c_0 exp(-k z/u) ahead of it, over a length that is 8 %
    longer in cells of one value: ln(1 + k h/u) instead of k h/u.
    """
    cells = GUARD.replace("cells = 8", "cells = 60") + "\n[solver]\ndegree = 0\n"
    qoi = at_rest(cells, "9e7 s", "A + G -> B", "k*c_G", "0.665 1/s")
    moles = 1e5 / (R_GAS * 400.0)
    u, c, n, k = 2.0 / moles, 1e-4 * moles, 0.6 * 1000.0 / 0.05, 0.665
    shares = np.array([0.05, 0.5])
    times = n / (k * c) + (1.0 + u / k * np.log(shares)) * n / (u * c)
    found = [qoi["breakthrough_5_G_s"], qoi["breakthrough_50_G_s"]]
    assert found == approx(times.tolist(), rel=0.04)
    assert qoi["conversion_A"] > 1.0 - 1e-9
    assert qoi["time_steps"] < 3000  # 1e9 where each begins with a moment of reaction


def test_a_zone_of_the_length_of_cells_is_a_warning():
    """Cells of one value, or damped ones; polynomials resolve a front of two cells."""
    line = SimpleNamespace(h=np.full(30, 0.01), degree=0)
    course = SimpleNamespace(on=lambda _: course, problem=SimpleNamespace(line=line))
    history = SimpleNamespace(damped=np.zeros(30, dtype=bool))
    zone = {"mass_transfer_zone_G_m": 0.02, "breakthrough_5_G_s": 1.0}
    (text,) = narrow_zones(course, history, zone)
    assert text.startswith("mass_transfer_zone_G_m = 0.02 m is 2 cells")
    assert not narrow_zones(course, history, {"mass_transfer_zone_G_m": 0.04})
    line.degree = 3
    assert not narrow_zones(course, history, zone)
    history.damped[4] = True
    assert narrow_zones(course, history, zone)


def test_the_conversion_of_a_solid_at_rest():
    """Of first order in what is left: 1 - exp(-k t)."""
    alike = GUARD.replace(
        "Fe = 1, O = 1 }, molar_mass = 0.08", "Fe = 1 }, molar_mass = 0.05"
    )
    qoi = at_rest(alike, "1000 s", "A -> B", "k*n_A", "1e-3 1/s")
    assert qoi["conversion_A"] == approx(1.0 - np.exp(-1.0), rel=1e-4)
