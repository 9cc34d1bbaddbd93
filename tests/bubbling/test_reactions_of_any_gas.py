"""Reactions by equation, law or formula in a bubbling bed, as in every other model."""

import numpy as np
from pytest import approx
from reacting_scenes import tube

import contbed as cb
from contbed.chemistry import laws
from contbed.chemistry.rate_law import RateLaw
from tests.cases import each_case
from tests.refusals import refused

T, P, R = 1200.0, 101325.0, 8.31446261815324
MIXTURE = "CO:0.001, H2O:0.5, N2:0.499"
SHIFT = {"equation": "CO + H2O -> CO2 + H2", "A": 0.05, "E": 0.0, "orders": {"CO": 1.0}}


def left(rate_per_volume_of_bed):
    """Share of a trace that is left after a tube of 0.05 m3, by plug flow."""
    mass = 0.001 * 28.01e-3 + 0.5 * 18.015e-3 + 0.499 * 28.014e-3
    flow = 0.02 / mass * R * T / P
    return np.exp(-rate_per_volume_of_bed * 0.05 / flow)


# 0.1 m3 that walls hold at the temperature of the bed
ABOVE = {
    "height": 1.0,
    "ejection": 1e-6,
    "decay": 3.0,
    "elutriation": 0.0,
    "walls": {"perimeter": 1.0, "coefficient": 1e3, "temperature": T},
}


def solved(reactions, composition=MIXTURE, freeboard=None):
    result = cb.run(tube(composition, reactions, freeboard))
    assert result.status == "ok", result.warnings
    for name, balance in result.balances.items():
        assert balance["relative_residual"] < 1e-9, name
    return result.qoi


def test_an_equation_with_constants():
    q = solved({"shift": SHIFT})
    share = q["x_CO_wet"] / (q["x_CO_wet"] + q["x_CO2_wet"])
    assert share == approx(left(0.05 * 0.45), rel=1e-3)
    formula = {"equation": SHIFT["equation"], "rate": "0.05*c_CO"}
    assert solved({"shift": formula})["x_CO_wet"] == approx(q["x_CO_wet"], rel=1e-9)


def test_gases_react_above_the_bed():
    """In twice the volume of the bed, without particles there."""
    q = solved({"shift": SHIFT}, freeboard=ABOVE)
    share = q["x_CO_wet"] / (q["x_CO_wet"] + q["x_CO2_wet"])
    assert share == approx(left(0.05 * (0.45 + 2.0)), rel=1e-3)


def test_particles_do_not_react_above_the_bed():
    of_particles = {"shift": SHIFT | {"basis": "catalyst", "A": 2.0e-5}}
    alone = solved(of_particles)
    below = solved(of_particles, freeboard=ABOVE)
    assert below["x_CO_wet"] == approx(alone["x_CO_wet"], rel=1e-6)


def test_a_rate_per_mass_of_particles():
    """The particles of a bed without bubbles fill 0.55 of it, at 2600 kg/m3."""
    per_kg = 2.0e-5
    q = solved({"shift": SHIFT | {"basis": "catalyst", "A": per_kg}})
    share = q["x_CO_wet"] / (q["x_CO_wet"] + q["x_CO2_wet"])
    assert share == approx(left(per_kg * 2600.0 * 0.55), rel=1e-3)


def test_a_law_of_several_equations(monkeypatch):
    """Two steps per mass of catalyst share one law; the factor scales both."""
    law = RateLaw(
        lambda case: lambda at: [4.0e-6 * at.c["CO"], 1.6e-5 * at.c["CO"]],
        equations=("CO + H2O -> CO2 + H2", "CO + H2O -> CO2 + H2"),
        basis="catalyst",
    )
    monkeypatch.setitem(laws.every(), "twice_the_shift", law)
    q = solved({"pair": {"law": "twice_the_shift", "factor": 0.5}})
    share = q["x_CO_wet"] / (q["x_CO_wet"] + q["x_CO2_wet"])
    assert share == approx(left(1.0e-5 * 2600.0 * 0.55), rel=1e-3)


def test_a_law_of_catalysts_that_packed_beds_have():
    q = solved(
        {"xu": {"law": "xu_froment_shift", "factor": 1e-3}},
        "CO:0.1, H2O:0.4, H2:0.1, CH4:0.1, CO2:0.1, N2:0.2",
    )
    assert q["x_H2_wet"] > 0.101


def test_gases_of_the_mechanism():
    """Ethane to ethylene: neither is among the gases that burn in the model's own
    laws.
    """
    crack = {"equation": "C2H6 -> C2H4 + H2", "A": 1.0, "E": 0.0}
    q = solved({"crack": crack}, "C2H6:0.01, N2:0.99")
    assert q["x_C2H4_wet"] == approx(q["x_H2_wet"], rel=1e-9)
    assert q["x_C2H4_wet"] > 1e-4


@each_case(__file__, "mistakes")
def test_mistakes(table, said):
    refused(said, tube, MIXTURE, {"shift": table})
