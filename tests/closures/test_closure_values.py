"""Reference numbers, limits and bounds of the closures.

Tolerances: 1e-7 where the reference is given with 8 digits, 1e-12 where two ways to the
    same number differ by round-off
only (some are differences of larger terms, hence not 1e-15).
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from contbed import closures
from contbed.closures.conductivity_cell import _log_tail

# Bed models, and how far each falls below the exact series bound where the
# conductivities are nearly equal: a property of the published formulas (their slope at
# k_solid = k_fluid is not 1 - eps), stated in their data sheets.
BEDS = {
    closures.conductivity_krupiczka: 0.002,
    closures.conductivity_kunii_smith: 0.016,
    closures.conductivity_zehner_schluender: 5e-5,
}
EXACT = [
    closures.conductivity_parallel,
    closures.conductivity_series,
    closures.conductivity_maxwell,
    closures.conductivity_hashin_shtrikman_lower,
    closures.conductivity_hashin_shtrikman_upper,
    closures.conductivity_hsu,
]
ratios = st.floats(-4, 4).map(lambda exponent: 10.0**exponent)
porosities = st.floats(0, 1)


# --- Nusselt ---


@pytest.mark.parametrize(
    ("eps", "expected"), [(0.49579176421443, 76.178587), (0.74789588210722, 40.462158)]
)
def test_gunn_of_the_two_readings_of_patil(eps, expected):
    assert closures.nusselt_gunn(395.0, 8.374, eps, exponent_Pr=0.33) == approx(
        expected, abs=5e-7
    )


def test_gunn_with_exponent_one_third():
    assert closures.nusselt_gunn(395.0, 8.374, 0.49579176421443) == approx(
        76.697, abs=5e-4
    )


def test_gunn_of_the_stagnant_single_sphere_is_two():
    assert closures.nusselt_gunn(0.0, 0.7, 1.0) == approx(2.0, rel=1e-15)


@pytest.mark.parametrize(
    "function", [closures.nusselt_wakao_kaguei, closures.nusselt_ranz_marshall]
)
def test_spheres_without_flow_have_nusselt_two(function):
    assert function(0.0, 0.7) == 2.0


def test_power_law_contains_wakao_and_ranz():
    Re = np.geomspace(1, 1e4, 7)
    assert closures.nusselt_power(Re, 0.7, 1.1, 0.6) == approx(
        closures.nusselt_wakao_kaguei(Re, 0.7)
    )
    assert closures.nusselt_power(Re, 0.7, 0.6, 0.5) == approx(
        closures.nusselt_ranz_marshall(Re, 0.7)
    )


def test_the_two_kuwahara_exponents_meet_at_reynolds_zero_and_one():
    for Re in (0.0, 1.0):
        assert closures.nusselt_kuwahara(
            Re, 0.7, 0.4
        ) == closures.nusselt_kuwahara_pivem(Re, 0.7, 0.4)
    assert closures.nusselt_kuwahara(0.0, 0.7, 0.5) == 5.0
    assert closures.nusselt_kuwahara(100.0, 0.7, 1.0) == 1.0


# --- conductivity ---


def test_hsu_reproduces_table_1_of_pivem():
    assert closures.conductivity_hsu(1.0, 40.0, 0.4) == approx(4.2929334, abs=5e-8)
    assert closures.tortuosity_hsu(1.0, 40.0, 0.4) == approx(-0.01321964, abs=5e-9)


@given(
    ratio=ratios.filter(lambda ratio: abs(ratio - 1) > 0.1), eps=st.floats(0.01, 0.99)
)
def test_tortuosity_is_the_printed_quotient(ratio, eps):
    printed = (closures.conductivity_hsu(1.0, ratio, eps) - eps - (1 - eps) * ratio) / (
        ratio - 1
    ) ** 2
    # The quotient is a difference of terms of order 1 + ratio.
    assert closures.tortuosity_hsu(1.0, ratio, eps) == approx(
        printed, rel=1e-12, abs=1e-14 * (1 + ratio) / (ratio - 1) ** 2
    )


@given(ratio=ratios, eps=porosities)
def test_exact_bounds_are_ordered(ratio, eps):
    series, lower, upper, parallel = (
        function(1.0, ratio, eps)
        for function in (
            closures.conductivity_series,
            closures.conductivity_hashin_shtrikman_lower,
            closures.conductivity_hashin_shtrikman_upper,
            closures.conductivity_parallel,
        )
    )
    slack = 1 + 1e-12
    assert series <= lower * slack
    assert lower <= upper * slack
    assert upper <= parallel * slack


@given(ratio=ratios, eps=porosities)
def test_hsu_and_maxwell_respect_the_bounds(ratio, eps):
    low = closures.conductivity_series(1.0, ratio, eps) * (1 - 1e-12)
    high = closures.conductivity_parallel(1.0, ratio, eps) * (1 + 1e-12)
    assert low <= closures.conductivity_hsu(1.0, ratio, eps) <= high
    low = closures.conductivity_hashin_shtrikman_lower(1.0, ratio, eps) * (1 - 1e-12)
    high = closures.conductivity_hashin_shtrikman_upper(1.0, ratio, eps) * (1 + 1e-12)
    assert low <= closures.conductivity_maxwell(1.0, ratio, eps) <= high


@pytest.mark.parametrize("function", BEDS)
@given(share=st.tuples(st.floats(0, 1), st.floats(0, 1)))
def test_bed_models_lie_between_series_and_parallel_in_their_range(function, share):
    low, high = function.sheet.ranges["eps"]
    eps = low + share[0] * (high - low)
    ratio = function.sheet.ranges["k_solid/k_fluid"][1] ** share[1]
    k = function(1.0, ratio, eps)
    slack = BEDS[function] if ratio < 2 else 1e-12
    assert closures.conductivity_series(1.0, ratio, eps) * (1 - slack) <= k
    assert k <= closures.conductivity_parallel(1.0, ratio, eps) * (1 + slack)


@pytest.mark.parametrize("function", [*EXACT, *BEDS])
@given(k=st.floats(1e-3, 1e3), eps=st.floats(0.05, 0.95))
def test_equal_phases_conduct_like_one(function, k, eps):
    assert function(k, k, eps) == approx(k, rel=1e-12)


@pytest.mark.parametrize(
    "function",
    [
        *EXACT,
        closures.conductivity_kunii_smith,
        closures.conductivity_zehner_schluender,
    ],
)
@pytest.mark.parametrize("k_solid", [0.01, 1.0, 30.0])
def test_bed_without_solid_conducts_like_the_fluid(function, k_solid):
    assert function(0.3, k_solid, 1.0) == approx(0.3, rel=1e-14)


@pytest.mark.parametrize("function", EXACT)
def test_bed_without_fluid_conducts_like_the_solid(function):
    assert function(0.3, 7.0, 0.0) == approx(7.0, rel=1e-14)


def zehner_bauer_as_printed(kappa, eps, R, shape):
    B = shape * ((1 - eps) / eps) ** (10 / 9)
    N = 1 + (R - B) / kappa
    c = (
        B * (kappa + R - 1) / (N**2 * kappa) * math.log((kappa + R) / B)
        + (B + 1) / (2 * B) * (R - B)
        - (B - 1) / N
    )
    root = math.sqrt(1 - eps)
    return (1 - root) * (1 + eps * R) + root * 2 / N * c


def zehner_as_printed(kappa, eps, shape):
    B = shape * ((1 - eps) / eps) ** (10 / 9)
    N = 1 - B / kappa
    c = (
        2
        / N
        * (
            B * (kappa - 1) / (N**2 * kappa) * math.log(kappa / B)
            - (B + 1) / 2
            - (B - 1) / N
        )
    )
    root = math.sqrt(1 - eps)
    return 1 - root + root * c


def kunii_as_printed(kappa, eps):
    def phi(n):
        cosine, e = math.sqrt(1 - 1 / n), (kappa - 1) / kappa
        return e**2 / (2 * n) / (
            math.log(kappa - (kappa - 1) * cosine) - e * (1 - cosine)
        ) - 2 / (3 * kappa)

    loose, dense = phi(1.5), phi(4 * math.sqrt(3))
    return eps + (1 - eps) / (
        dense + (loose - dense) * (eps - 0.26) / 0.216 + 2 / (3 * kappa)
    )


# The printed forms lose digits near their 0/0, so the comparison keeps away from it and
# allows 1e-9.
@pytest.mark.parametrize("kappa", [0.3, 0.8, 4.0, 30.0, 900.0])
@pytest.mark.parametrize("eps", [0.3, 0.4, 0.47])
@pytest.mark.parametrize("shape", [1.25, 2.5])
def test_regular_forms_equal_the_printed_ones(kappa, eps, shape):
    zehner = closures.conductivity_zehner_schluender(
        0.05, 0.05 * kappa, eps, shape=shape
    )
    assert zehner == approx(0.05 * zehner_as_printed(kappa, eps, shape), rel=1e-9)
    kunii = closures.conductivity_kunii_smith(0.05, 0.05 * kappa, eps)
    assert kunii == approx(0.05 * kunii_as_printed(kappa, eps), rel=1e-9)
    T, d_p, emissivity = 900.0, 0.004, 0.7
    R = 4 * 5.670374419e-8 * T**3 * d_p / ((2 / emissivity - 1) * 0.05)
    bauer = closures.conductivity_zehner_bauer_schluender(
        0.05, 0.05 * kappa, eps, T, d_p, emissivity, shape=shape
    )
    assert bauer == approx(
        0.05 * zehner_bauer_as_printed(kappa, eps, R, shape), rel=1e-9
    )


def test_zehner_at_its_printed_singularity():
    eps = 0.45
    B = 1.25 * ((1 - eps) / eps) ** (10 / 9)
    # At kappa = B the bracket tends to 1 + 2 (B - 1) / 3: the first term of the
    # logarithm series.
    root = math.sqrt(1 - eps)
    expected = 1 - root + root * (1 + 2 * (B - 1) / 3)
    assert closures.conductivity_zehner_schluender(1.0, B, eps) == approx(
        expected, rel=1e-13
    )


def test_radiation_off_gives_zehner_and_contact_adds():
    cold = closures.conductivity_zehner_bauer_schluender(
        0.05, 1.0, 0.4, 900.0, 0.004, 1e-12
    )
    assert cold == approx(
        closures.conductivity_zehner_schluender(0.05, 1.0, 0.4), rel=1e-9
    )
    hot = [
        closures.conductivity_zehner_bauer_schluender(0.05, 1.0, 0.4, T, 0.004, 0.8)
        for T in (300.0, 900.0, 1500.0)
    ]
    assert cold < hot[0] < hot[1] < hot[2]
    touching = closures.conductivity_zehner_bauer_schluender(
        0.05, 1.0, 0.4, 300.0, 0.004, 0.8, contact=0.0077
    )
    assert touching > hot[0]


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize(
    "z",
    [
        -0.9,
        -0.29,
        -0.100001,
        -0.099999,
        -1e-9,
        0.0,
        1e-3,
        0.0999999,
        0.1000001,
        0.29,
        0.8,
    ],
)
def test_log_tail_is_its_integral(order, z):
    t, weight = np.polynomial.legendre.leggauss(60)
    t = (t + 1) / 2
    integral = np.sum(weight / 2 * t ** (order - 1) / (1 - t * z))
    # Just outside |z| = 0.1 the closed form loses 3 digits.
    assert _log_tail(1 - z, order) == approx(integral, rel=1e-12)


# --- dispersion, pressure drop, wall ---


def test_dispersion_vanishes_without_flow_and_is_stronger_along_it():
    for stem in ("dispersion_wakao_kaguei", "dispersion_vdi"):
        pair = closures.dispersion_pair(stem)
        tube = {"d_p": 0.005, "D_bed": 0.1}
        call = {
            f: {key: tube[key] for key in f.sheet.arguments if key in tube}
            for f in pair
        }
        along, across = (f(Pe=100.0, k_fluid=0.03, **call[f]) for f in pair)
        assert all(f(Pe=0.0, k_fluid=0.03, **call[f]) == 0 for f in pair)
        assert along > across > 0


def test_vdi_transverse_in_a_wide_tube_is_one_seventh():
    wide = closures.dispersion_vdi_transverse(Pe=70.0, k_fluid=1.0, d_p=1e-9, D_bed=1.0)
    assert wide == approx(10.0, rel=1e-8)


@given(u=st.floats(-3, 3), eps=st.floats(0.3, 0.6))
def test_ergun_gradient_is_darcy_plus_forchheimer(u, eps):
    d_p, mu, rho = 2e-3, 1.8e-5, 1.2
    K = closures.permeability_ergun(d_p, eps)
    expected = mu * u / K + closures.forchheimer_ergun(eps) * rho * abs(
        u
    ) * u / math.sqrt(K)
    assert closures.pressure_gradient_ergun(u, d_p, eps, mu, rho) == approx(
        expected, rel=1e-12
    )


def test_permeabilities_differ_by_their_constants():
    d_p, eps = 2e-3, 0.37
    carman = closures.permeability_carman_kozeny(d_p, eps)
    assert closures.permeability_ergun(d_p, eps) / carman == approx(180 / 150)
    assert closures.permeability_kuwahara(d_p, eps) / carman == approx(180 / 144)
    assert closures.permeability_pivem(d_p, eps) * eps == approx(
        closures.permeability_kuwahara(d_p, eps)
    )


def test_permeability_pivem_of_table_3():
    # Table 3 prints K = 5.062E-06 for D = 3 mm and phi = 0.9.
    assert closures.permeability_pivem(3e-3, 0.9) == approx(5.062e-6, rel=1e-4)


def test_wall_coefficients():
    bed = {"Re": 300.0, "Pr": 0.7, "k_fluid": 0.03, "d_p": 0.006, "D_bed": 0.06}
    assert closures.wall_li_finlayson(**bed) * 0.006 / 0.03 == approx(
        0.17 * 300**0.79, rel=1e-12
    )
    still = closures.wall_martin_nilles(**(bed | {"Re": 0.0}), k_stagnant=0.2)
    assert still == approx(1.8 * 0.2 / 0.006, rel=1e-12)
    moving = closures.wall_martin_nilles(**bed, k_stagnant=0.2)
    assert (moving - still) * 0.006 / 0.03 == approx(
        0.19 * 300**0.75 * 0.7 ** (1 / 3), rel=1e-12
    )


# --- drag ---


def test_beetstra_in_its_limits():
    """Stokes's single sphere to rounding; a packed bed without inertia is Carman's
    180 and the second term of F.
    """
    mu, d = 1.8e-5, 1e-3
    single = closures.drag_beetstra(Re=0.0, eps=1.0 - 1e-9, d_p=d, mu=mu) / (
        1e-9 * 18.0 * mu / d**2
    )
    assert single == approx(1.0, rel=1e-4)
    eps = 0.4
    still = closures.drag_beetstra(Re=0.0, eps=eps, d_p=d, mu=mu) * d**2 / mu
    carman = 180.0 * (1 - eps) ** 2 / eps
    second = 18.0 * (1 - eps) * eps**3 * (1 + 1.5 * (1 - eps) ** 0.5)
    assert still == approx(carman + second, rel=1e-12)


def test_beetstra_beside_ergun_in_a_packed_bed():
    """Both describe random packings: within 20 % at eps = 0.4 for Re from 1 to 300;
    at 1000 Ergun has a third more.
    """
    Re = np.logspace(0, np.log10(300.0), 13)
    ratio = closures.drag_beetstra(Re, 0.4, 1e-3, 1.8e-5) / closures.drag_gidaspow(
        Re, 0.4, 1e-3, 1.8e-5
    )
    assert np.all(np.abs(ratio - 1.0) < 0.20), ratio
