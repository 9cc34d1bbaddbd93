"""Fully developed flow: the reference of three independent discretisations, gas alone
against Poiseuille's profiles, the order of refinement, momentum over the section, and
what must hold at centre and wall.
"""

from pathlib import Path

import numpy as np
import pytest
from pytest import approx
from scipy.integrate import cumulative_trapezoid, trapezoid

import contbed as cb
from tests.balances import assert_closed

SCENE = Path(__file__).parents[2] / "studies" / "two_fluid_checks" / "developed.toml"
PACKING, RESTITUTION, DIAMETER, DENSITY = 0.6, 0.95, 1e-3, 2500.0


def run(**overrides):
    return cb.run(
        cb.load(
            SCENE, {key.replace("__", "."): value for key, value in overrides.items()}
        )
    )


@pytest.fixture(scope="module")
def channel():
    return run()


def test_reference(channel):
    # collocation by three discretisations, which agree to 5e-7 at worst; -dp/dz, centre
    # | wall
    expected = {
        "pressure_gradient_Pa_m": 894.51612, "u_gas_centre": 5.7338970, "u_solid_centre": 1.1693291,
        "u_solid_wall": 1.4396601, "theta_centre": 0.027872205, "theta_wall": 0.28117189,
        "eps_solid_centre": 0.057977764, "eps_solid_wall": 0.0078356341,
    }  # fmt: skip
    for name, value in expected.items():
        assert channel.qoi[name] == approx(value, rel=1e-6), name


def test_balances_close(channel):
    # the equations of the two numbers and the sum of the momenta hold to the rounding
    # of Newton's method
    assert_closed(channel, 1e-10, "momentum", "gas flow", "solids flow")


def test_pressure_of_particles_is_level(channel):
    s, theta = channel.profiles["eps_s [1]"], channel.profiles["theta [m2/s2]"]
    g0 = 1 / (1 - (s / PACKING) ** (1 / 3))
    p = DENSITY * theta * s * (1 + 2 * (1 + RESTITUTION) * s * g0)
    np.testing.assert_allclose(p, p[0], rtol=1e-9)


def test_shear_carries_the_weight_from_the_wall_inward(channel):
    """Momentum of both phases from the centre to r: stresses at r against weight less
    push, of the profiles alone.

    2e-3: stresses by differences between nodes, not at the ends.
    """
    c = channel.profiles
    r, s = c["r [m]"], c["eps_s [1]"]
    force = channel.qoi["pressure_gradient_Pa_m"] - 9.81 * (s * DENSITY + (1 - s) * 1.2)
    carried = -cumulative_trapezoid(force, r, initial=0.0)
    g0 = 1 / (1 - (s / PACKING) ** (1 / 3))
    e, contact = RESTITUTION, 0.8 * s * (1 + RESTITUTION) * g0
    mu = (
        contact * s / np.pi**0.5
        + 10 * np.pi**0.5 / (96 * (1 + e) * g0) * (1 + contact) ** 2
    )
    mu = mu * DENSITY * DIAMETER * np.sqrt(c["theta [m2/s2]"])
    stress = mu * np.gradient(c["u_solid [m/s]"], r) + 1.8e-5 * np.gradient(
        c["u_gas [m/s]"], r
    )
    inner = (r > 0) & (r < 0.99 * r[-1])
    assert np.abs(stress - carried)[inner].max() < 2e-3 * np.abs(carried).max()


@pytest.mark.parametrize(("section", "peak"), [("channel", 1.5), ("pipe", 2.0)])
def test_gas_alone_is_parabolic(section, peak):
    result = run(
        developed_flow__section=section,
        developed_flow__solids_mass_flux=0.0,
        developed_flow__gas_velocity=0.1,
    )
    r, u = result.profiles["r [m]"], result.profiles["u_gas [m/s]"]
    np.testing.assert_allclose(u, 0.1 * peak * (1 - (r / r[-1]) ** 2), atol=1e-10)
    shear = 2 * peak * 0.1 * 1.8e-5 / r[-1] ** 2 * (2 if section == "pipe" else 1)
    assert result.qoi["pressure_gradient_Pa_m"] == approx(1.2 * 9.81 + shear, rel=1e-10)


def test_refinement_of_quadratic_elements():
    """Differences of -dp/dz fall by 2^4 at least in the mean, as twice the degree of
    the elements says.
    """
    values = [
        run(solver__degree=2, solver__cells=n).qoi["pressure_gradient_Pa_m"]
        for n in (10, 20, 40)
    ]
    errors = np.abs(np.array(values) - 894.51612)
    assert np.log2(errors[0] / errors[2]) / 2 > 3.0
    assert errors[2] < 1e-4 * 894.5


def test_pipe_holds_the_same_conditions():
    result = run(developed_flow__section="pipe")
    c = result.profiles
    r, s = c["r [m]"], c["eps_s [1]"]
    for carried, given in (
        ((1 - s) * c["u_gas [m/s]"], 9.0),
        (DENSITY * s * c["u_solid [m/s]"], 100.0),
    ):
        mean = 2 * trapezoid(carried * r, r) / r[-1] ** 2
        assert mean == approx(given, rel=1e-3)  # trapezoids between nodes
    assert_closed(result, 1e-10, "momentum")


def test_guesses_lead_to_the_branch_that_is_told():
    found = [
        run(developed_flow__granular_temperature_centre=guess).qoi["theta_centre"]
        for guess in (0.005, 0.3)
    ]
    assert found == approx([0.027872205] * 2, rel=1e-6)
