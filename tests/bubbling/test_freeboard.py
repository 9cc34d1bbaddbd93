"""The freeboard above a bed: flows of particles, gas that walls cool, heat that
particles carry back, balances.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from bubbling_scenes import solved
from computed_scenes import hot
from pytest import approx
from scipy.integrate import solve_ivp

import contbed as cb
from contbed.bubbling_bed.equations.freeboard import CLEAR, LocalCoefficients
from contbed.bubbling_bed.plan import plan
from contbed.closures.optics import SIGMA
from contbed.materials import gas_mixture

WALLS = {"perimeter": 3.5, "coefficient": 20.0, "temperature": 600.0, "emissivity": 0.8}


def column(result, name):
    """A profile above the bed, with the height above its surface."""
    values = result.profiles[name]
    above = ~np.isnan(values)
    return result.profiles["z [m]"][above] - 0.6, values[above]


def test_particles_fall_off_exponentially():
    given = {"height": 2.0, "ejection": 40.0, "decay": 3.0, "elutriation": 0.5}
    result = solved(hot(freeboard=given))
    y, flow = column(result, "flow_up [kg/m2/s]")
    # cubic elements on the mesh of the bed: 12 decay lengths
    assert flow == approx(0.5 + 39.5 * np.exp(-3.0 * y), rel=1e-4)
    assert result.qoi["carryover_kg_s"] == approx(0.5 + 39.5 * np.exp(-6.0), rel=1e-4)


def test_nothing_thrown_up_brings_no_warning_of_what_is_lost():
    given = {"height": 2.0, "ejection": 0.0, "decay": 3.0, "elutriation": 0.0}
    result = solved(hot(freeboard=given))
    assert result.qoi["carryover_kg_s"] == approx(0.0, abs=1e-12)
    assert not [text for text in result.warnings if "carries away" in text]


def test_gas_without_particles_is_cooled_by_the_walls():
    """m h' = p h_w (T_w - T) from the mixture of both gases at the surface of the
    bed.
    """
    given = {
        "height": 2.0,
        "ejection": 1e-7,
        "decay": 3.0,
        "elutriation": 0.0,
        "gas_coefficient": 1e-3,
        "walls": {**WALLS, "emissivity": None},
    }
    given["walls"].pop("emissivity")
    result = solved(
        hot(
            freeboard=given,
            radiation=None,
            distributor={"coefficient": 80.0, "preheat_NTU": 2.5},
        )
    )
    gas = gas_mixture("N2:0.79, O2:0.21", 101325.0)
    y, T = column(result, "T_freeboard [K]")
    top = np.flatnonzero(np.isclose(result.profiles["z [m]"], 0.6))[0]
    bubbles = result.profiles["flow_bubble [kg/s]"][top]
    mixed = sum(
        flow * gas.enthalpy(result.profiles[f"T_{name} [K]"][top])
        for name, flow in (("bubble", bubbles), ("emulsion", 0.6 - bubbles))
    )
    assert 0.6 * gas.enthalpy(T[0]) == approx(mixed, rel=1e-5)
    exact = solve_ivp(
        lambda y, T: 3.5 * 20.0 * (600.0 - T) / (0.6 * gas.heat_capacity(T)),
        (0, 2),
        T[:1],
        t_eval=y,
        rtol=1e-10,
    )
    assert np.abs(T - exact.y[0]).max() < 1e-4  # of 100 K
    lost = 0.6 * (gas.enthalpy(T[0]) - gas.enthalpy(T[-1]))
    assert result.qoi["freeboard_walls_convection_W"] == approx(lost, rel=1e-6)


def test_many_particles_bring_the_gas_to_the_temperature_of_the_bed():
    """50 kg/m2/s hold a hundred times the heat of the gas, which leaves the bubbles
    cold.
    """
    above = {"height": 2.0, "decay": 3.0, "elutriation": 0.0, "ejection": 50.0}
    result = solved(
        hot(
            freeboard=above,
            radiation=None,
            initial={"temperature": 700.0},
            distributor={"coefficient": 80.0, "preheat_NTU": 2.5},
        )
    )
    surface = result.profiles["T_inert [K]"][
        np.flatnonzero(np.isclose(result.profiles["z [m]"], 0.6))[0]
    ]
    gas, up = (column(result, name)[1] for name in ("T_freeboard [K]", "T_up [K]"))
    assert surface - gas[0] > 5 and abs(surface - gas[-1]) < 1
    assert gas[-1] == approx(up[-1], abs=0.1)


def test_walls_above_cool_the_bed():
    base = {"height": 3.0, "temperature_above": 700.0}
    adiabatic, cooled = (
        solved(hot(freeboard=base | more)) for more in ({}, {"walls": WALLS})
    )
    assert cooled.qoi["T_inert_mid_K"] < adiabatic.qoi["T_inert_mid_K"]
    assert cooled.qoi["freeboard_walls_radiation_W"] > 0
    # radiation is continuous through the surface of the bed, to one over the factor
    # that joins both sides
    z, G = cooled.profiles["z [m]"], cooled.profiles["G [W/m2]"]
    top = np.flatnonzero(np.isclose(z, 0.6))[0]
    assert column(cooled, "G_freeboard [W/m2]")[1][0] == approx(G[top], rel=1e-5)


class At(float):
    """A field at a point: its value, and its slope along the height."""

    def __new__(cls, value, slope=0.0):
        found = super().__new__(cls, value)
        found.slope = slope
        return found


def test_black_particles_take_radiation_as_they_weaken_it():
    """Large black particles scatter nothing: extinction is absorption, a quarter of
    their surface per volume.

    Both are read from the weak form of G at particles of 900 K, 30 kg/m2/s up and 20
    kg/m2/s down.
    """
    here = LocalCoefficients(
        0.6, lambda T: 1e3 * T, lambda T: 1e3, 3.0, 0.0, 500.0, 100.0
    )
    scene = hot(freeboard={"height": 2.0, "ejection": 40.0, "decay": 3.0})
    part = plan(scene).coefficients.computed.above.part
    part = replace(part, emissivity=1.0, local_coefficients=lambda u, o: here)
    black, o = (
        4.0 * SIGMA * 900.0**4,
        SimpleNamespace(h=0.1, grad=lambda field: (field.slope,)),
    )
    bed = dict.fromkeys(("T_freeboard", "T_up", "T_down"), At(900.0)) | {
        "flow_up": At(30.0),
        "carryover": At(10.0),
    }
    none = dict.fromkeys((*part.fields, *part.scalars), At(0.0))

    def balance(G, test):
        u, tests = (
            SimpleNamespace(**known | {"G_freeboard": field})
            for known, field in ((bed, G), (none, test))
        )
        return part.residual(u, tests, None, None, o)

    taken = balance(At(black + 1e3), At(1.0)) - balance(At(black), At(1.0))
    absorption = taken / (1e3 * part.section * part.stretch)
    diffusion = balance(At(black, 1.0), At(0.0, 1.0)) * part.stretch / part.section
    assert absorption == approx(0.25 * part.surface * (30.0 + 20.0) / 500.0, rel=1e-9)
    assert 1.0 / (3.0 * diffusion) == approx(absorption + CLEAR / 2.0, rel=1e-9)


def test_a_freeboard_needs_its_gas_and_one_choice():
    with pytest.raises(cb.errors.SceneError, match="has no use without height"):
        hot(freeboard={"temperature": 900.0, "ejection": 3.0})
    with pytest.raises(
        cb.errors.SceneError, match="give one of radiosity, temperature, height"
    ):
        hot(freeboard={})


def test_pressure_drop_and_temperature_of_what_leaves():
    """The weight of particles between the bubbles, and the end of the profile."""
    result = solved(hot(freeboard={"height": 2.0}))
    scene, z = result.plan.scene, result.profiles["z [m]"]
    share = result.qoi["height_at_minimum_fluidization_m"]
    density = sum(each.volume_share * each.density for each in scene.present.values())
    weight = 9.81 * scene.bubbling_bed.solids_fraction * density * share
    assert result.qoi["pressure_drop_Pa"] == approx(weight, rel=1e-12)
    out = result.profiles["T_freeboard [K]"][np.argmax(z)]
    assert result.qoi["T_freeboard_out_K"] == approx(out, rel=1e-12)
