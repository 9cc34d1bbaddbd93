"""Shortest heater, counter-current with constant properties, against its exact
solution; runs of the real solver.
"""

import json

import pytest
from scipy.optimize import brentq

from studies._exact.finite_length import finite_length
from tests.command_line import command

GAS_IN, SOLID_IN = 300.0, 900.0
ASKED = 850.0  # K of the gas at its outlet
SMALLEST = 0.008  # m, diameter of the particles
SCENE = f"""\
[mesh]
type = "line"
length = 0.2
[gas]
density = 0.5
heat_capacity = 1000
conductivity = 0.05
viscosity = 3e-5
[solids.particles]
density = 2000
heat_capacity = 800
conductivity = 0.5
diameter = 0.01
[packed_bed]
porosity = 0.4
[closures]
nusselt = 12
[heat]
[boundary.left]
gas.velocity = 0.3
gas.fixed_temperature = {GAS_IN}
[boundary.right]
solids.particles.velocity = 1.5e-4
solids.particles.fixed_temperature = {SOLID_IN}
[solver]
tolerance = 1e-7
[output]
plots = false
fields = false
"""
DESIGN = """\
scene = "scene.toml"
minimise = "mesh.length"
constraints = ["T_fluid_out_K >= {asked}"]
[keys]
mesh.length = {{ from = "0.01 m", to = "1 m" }}
solids.particles.diameter = {{ from = "8 mm", to = "30 mm" }}
"""


def outlet(length, d):
    """Gas at its outlet by the exact solution [K]."""
    eps = 0.4
    ha = 6.0 * (1.0 - eps) / d * 12.0 * 0.05 / d
    f, _ = finite_length(
        length,
        length,
        0.5 * 1000 * 0.3,
        -2000 * 800 * 1.5e-4,
        eps * 0.05,
        (1 - eps) * 0.5,
        ha,
    )
    return GAS_IN + (SOLID_IN - GAS_IN) * float(f)


def shortest(asked, d):
    """Length at which the gas leaves as hot as asked for; it is shortest for the
    smallest particles.
    """
    return brentq(lambda at: outlet(at, d) - asked, 0.01, 1.0, xtol=1e-14)


def test_length_and_prices_are_those_of_the_exact_solution(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "design.toml").write_text(DESIGN.format(asked=ASKED))
    assert command("optimise design.toml --out out --quiet") == 0
    found = json.loads((tmp_path / "out" / "summary.json").read_text())
    keys = found["keys"]
    assert keys["solids.particles.diameter"]["value"] == SMALLEST
    # the solver has 1e-7 of theta, and the constraint holds to 1e-6 of its change over
    # the bounds
    assert keys["mesh.length"]["value"] == pytest.approx(
        shortest(ASKED, SMALLEST), rel=1e-5
    )
    step = 0.05
    slope = (shortest(ASKED + step, SMALLEST) - shortest(ASKED - step, SMALLEST)) / (
        2.0 * step
    )
    # the price is for what is less asked for
    assert -found["constraints"][0]["price"] == pytest.approx(slope, rel=1e-3)
    step = 1e-6
    slope = (shortest(ASKED, SMALLEST + step) - shortest(ASKED, SMALLEST - step)) / (
        2.0 * step
    )
    assert keys["solids.particles.diameter"]["price_of_bound"] == pytest.approx(
        slope, rel=1e-3
    )
