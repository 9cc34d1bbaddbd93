"""Fully developed flow: a solution that was not meant, rough walls, and
scenes that cannot be run.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

import contbed as cb
from contbed.closures.granular import g0_sinclair_jackson
from contbed.closures.granular_transport import (
    granular_conductivity_syamlal,
    granular_dissipation_lun,
)
from contbed.developed_flow.equations import Coefficients
from contbed.developed_flow.plan import coefficients
from contbed.errors import ConvergenceError, SceneError
from tests.balances import assert_closed
from tests.cases import each_case

SCENE = Path(__file__).parents[2] / "studies" / "two_fluid_checks" / "developed.toml"


def load(**overrides):
    return cb.load(SCENE, overrides)


def test_one_solution_says_when_another_was_meant():
    result = cb.run(load(**{"developed_flow.granular_temperature_centre": 0.3}))
    assert result.qoi["theta_centre"] == pytest.approx(0.027872205, rel=1e-6)
    assert any("not near 0.3" in text for text in result.warnings)


def test_rough_wall_holds_particles_back():
    """Specularity 1 is reached through smoother walls. Particles are slower at the
    wall and the drop is larger.
    """
    smooth, rough = (
        cb.run(load(**{"boundary.wall.solids.beads.specularity": value}))
        for value in (0.05, 1.0)
    )
    assert rough.qoi["u_solid_wall"] < 0.2 * smooth.qoi["u_solid_wall"]
    assert (
        rough.qoi["pressure_gradient_Pa_m"] > 2 * smooth.qoi["pressure_gradient_Pa_m"]
    )
    assert_closed(rough, 1e-10, "momentum")


def test_pipe_holds_its_momentum_and_granular_energy_up_to_every_radius():
    """Both stresses carry weight less push; what is sheared dissipates or is conducted
    to the wall: by trapezoids and differences between nodes, 2e-3 and 1e-2 of the
    largest.
    """
    result = cb.run(load(**{"developed_flow.section": "pipe", "solver.cells": 120}))
    c = result.profiles
    r, eps_s, theta, mu, beta = (
        c[name]
        for name in (
            "r [m]",
            "eps_s [1]",
            "theta [m2/s2]",
            "mu_solid [Pa s]",
            "beta [kg/m3/s]",
        )
    )
    force = result.qoi["pressure_gradient_Pa_m"] - 9.81 * (
        2500.0 * eps_s + 1.2 * (1 - eps_s)
    )
    shear = np.gradient(c["u_solid [m/s]"], r)
    stress = r * (mu * shear + 1.8e-5 * np.gradient(c["u_gas [m/s]"], r))
    carried = -cumulative_trapezoid(force * r, r, initial=0.0)
    inner = (r > 0) & (r < 0.99 * r[-1])
    assert np.abs(stress - carried)[inner].max() < 2e-3 * np.abs(carried).max()
    g0 = g0_sinclair_jackson(eps_s, 0.6)
    k = 2500.0 * 1e-3 * theta**0.5 * granular_conductivity_syamlal(eps_s, g0, 0.95)
    gamma = 2500.0 / 1e-3 * theta**1.5 * granular_dissipation_lun(eps_s, g0, 0.95)
    left = cumulative_trapezoid(
        (gamma + 3 * beta * theta - mu * shear**2) * r, r, initial=0.0
    )
    assert (
        np.abs(r * k * np.gradient(theta, r) - left)[inner].max()
        < 1e-2 * np.abs(left).max()
    )


@pytest.mark.parametrize("name", ["sinclair_jackson", "lun_savage", "ma_ahmadi"])
def test_fraction_inverts_the_pressure(name):
    c: Coefficients = coefficients(
        load(**{"closures.radial_distribution": f"g0_{name}"})
    )
    eps_s = c.eps_max * np.array([1e-9, 1e-3, 0.1, 0.5, 0.9, 0.999])
    np.testing.assert_allclose(
        c.fraction(c.relative_pressure(eps_s)), eps_s, rtol=1e-11
    )


def test_no_fraction_below_packing_is_no_number():
    c = coefficients(load(**{"closures.radial_distribution": "g0_carnahan_starling"}))
    assert np.isnan(c.fraction(2.0 * c.relative_pressure(c.eps_max)))


@each_case(__file__, "bad_scenes_say_what_is_wrong")
def test_bad_scenes_say_what_is_wrong(key, value, said):
    with pytest.raises(SceneError) as error:
        load(**{key: value})
    assert said in str(error.value) and key.split(".")[0] in str(error.value)


def test_gas_that_would_be_turbulent_is_told():
    """9 m/s of air between plates 30.4 mm apart: Re = 18 240."""
    planned = cb.plan(load())
    said = (
        "developed_flow.gas_velocity = 9.0: the gas alone would be turbulent, Re = "
        "1.82e+04"
    )
    assert any(said in text for text in planned.scene.warnings)
    assert "WARNING" in str(planned)
    slow = load(
        **{"developed_flow.solids_mass_flux": 0.0, "developed_flow.gas_velocity": 0.1}
    )
    assert slow.warnings == () == tuple(cb.run(slow).warnings)


def test_a_search_that_fails_ends_with_advice():
    with pytest.raises(
        ConvergenceError,
        match=r"no solution found(.|\n)*try granular_temperature_centre = .*a solids_mass_flux below",
    ):
        cb.run(load(**{"solver.newton_iterations": 1}))


def test_a_wall_too_smooth_for_fluctuations_is_told():
    """0.3 mm in a riser of 120 mm: a wall of specularity 0.05 carries them, one of
    0.001 does not.
    """
    riser = {
        "gas.density": 1.0,
        "gas.viscosity": 3.2e-5,
        "solids.beads.diameter": 3e-4,
        "solids.beads.density": 1500.0,
        "developed_flow.section": "pipe",
        "developed_flow.radius": 0.06,
        "developed_flow.solids_mass_flux": 40.0,
        "closures.turbulence": "eddy_viscosity_nikuradse",
    }
    smooth = {"boundary.wall.solids.beads.specularity": 1e-3}
    with pytest.raises(ConvergenceError, match=r"makes few fluctuations.*try 0\.05"):
        cb.run(load(**riser, **smooth))
    assert cb.run(load(**riser)).qoi["theta_centre"] > 1e-4
