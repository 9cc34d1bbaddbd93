"""Closures of fluidized beds: limits, the Ergun equation behind minimum
fluidization, worked numbers.
"""

import numpy as np
import pytest
from pytest import approx

from contbed import closures

MINIMUM = {
    closures.minimum_fluidization_wen_yu: (33.7, 0.0408),
    closures.minimum_fluidization_grace: (27.2, 0.0408),
    closures.minimum_fluidization_chitester: (28.7, 0.0494),
    closures.minimum_fluidization_richardson: (25.7, 0.0365),
    closures.minimum_fluidization_saxena_vogel: (25.3, 0.0571),
    closures.minimum_fluidization_babu: (25.3, 0.0651),
}


@pytest.mark.parametrize("function", MINIMUM)
def test_minimum_fluidization_solves_its_quadratic(function):
    """K1 Re^2 + K2 Re = Ar with 1/K1 = C2 and K2/(2 K1) = C1."""
    c1, c2 = MINIMUM[function]
    Ar = np.logspace(0.5, 8, 30)
    Re = function(Ar)
    assert (Re**2 + 2 * c1 * Re) / c2 == approx(Ar, rel=1e-14)


def test_minimum_fluidization_of_sand():
    """Sand of 0.5 mm in air, step by step: Ar = 11804, sqrt(33.7^2 + 481.6) = 40.21,
    Re = 6.515, u_mf = 0.1955 m/s.
    """
    rho, mu, d_p = 1.2, 1.8e-5, 5e-4
    Ar = d_p**3 * rho * (2600 - rho) * 9.81 / mu**2
    u_mf = closures.minimum_fluidization_wen_yu(Ar) * mu / (rho * d_p)
    assert u_mf == approx(0.1955, abs=1e-4)
    assert closures.minimum_fluidization_grace(
        Ar
    ) > closures.minimum_fluidization_wen_yu(Ar)


def test_bubbles_grow_from_the_distributor_to_their_largest():
    size = closures.bubble_size_mori_wen(np.array([0.0, 0.5, 1.0, 1e3]), 0.02, 0.3, 0.8)
    assert size[0] == approx(0.02, rel=1e-14) and np.all(np.diff(size) > 0)
    # in the units of the original, cm and s: 0.652 [A (u - u_mf)]^0.4, rounded
    # constants
    assert size[-1] == approx(0.01 * 0.652 * (np.pi / 4 * 80**2 * 30) ** 0.4, rel=5e-3)
    assert closures.bubble_rise_davidson_harrison(1e-12, 0.3, 1.0) == approx(
        0.3, rel=1e-4
    )


def test_exchange_in_series_and_side_by_side():
    d_b, u_mf, D, eps = 0.06, 0.05, 2e-5, 0.45
    series = closures.gas_exchange_kunii_levenspiel(d_b, u_mf, D, eps)
    assert series < closures.gas_exchange_kunii_levenspiel(d_b, 1e9, D, eps)
    # without throughflow both steps are diffusion, with the square root of D
    slow = [
        closures.gas_exchange_kunii_levenspiel(d_b, 0.0, factor * D, eps)
        for factor in (1, 4)
    ]
    assert slow[1] == approx(2 * slow[0], rel=1e-13)
    assert closures.gas_exchange_sit_grace(d_b, u_mf, 0.0, eps, 1.0) == approx(
        2 * u_mf / d_b, rel=1e-15
    )
    heat = closures.bubble_heat_kunii_levenspiel(d_b, u_mf, 0.3, 1150.0, 0.0)
    assert heat == approx(4.5 * u_mf * 345.0 / d_b, rel=1e-15)


def test_heat_is_gas_exchange_where_lewis_is_one():
    """K_bc rho cp = H_b when the diffusivities of gas and heat are equal;
    K_ce -> inf with the voidage.
    """
    d_b, u_mf, rho, cp, k = 0.06, 0.05, 0.3, 1150.0, 0.075
    bubble_cloud = closures.gas_exchange_kunii_levenspiel(
        d_b, u_mf, k / (rho * cp), 1e30
    )
    heat = closures.bubble_heat_kunii_levenspiel(d_b, u_mf, rho, cp, k)
    assert heat == approx(rho * cp * bubble_cloud, rel=1e-12)


@pytest.mark.parametrize("Ar", [1e-15, 1e-6])
@pytest.mark.parametrize("function", MINIMUM)
def test_minimum_fluidization_of_fine_particles_is_creeping(function, Ar):
    """The next term of the series is C2 Ar/(4 C1^2) of the first; nothing else is
    lost.
    """
    C1, C2 = MINIMUM[function]
    assert function(Ar) == approx(0.5 * C2 * Ar / C1, rel=C2 * Ar / C1**2 + 1e-14)


def test_minimum_fluidization_by_ergun_of_fine_particles_is_that_of_carman():
    eps, shape = 0.45, 0.9
    K2 = 150.0 * (1.0 - eps) / (shape**2 * eps**3)
    assert closures.minimum_fluidization_ergun(1e-12, eps, shape) == approx(
        1e-12 / K2, rel=1e-11
    )
