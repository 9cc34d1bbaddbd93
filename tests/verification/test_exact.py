"""Exact solutions against published values, limits and their own equations; that of a
bed of finite length, Schumann's and that of the channel agree with runs as well.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pytest import approx
from scipy.linalg import expm

import contbed as cb
from contbed.loading import from_dict, loads
from studies import _exact as exact
from tests.balances import assert_closed
from tests.numbers_of import rows_of
from tests.scene_text import scene_of

# Pivem and de Lemos (2012): Table 2 properties; Table 3 rows as name: (u_D, u_s/u_D, D,
# porosity, Re_D, C_s/C_f, k_s/k_f), then theta_eq and L_1% computed for contbed with 50
# digits.
K_FLUID, RHO_FLUID, CP_FLUID, MU_FLUID = 0.0345, 0.4345, 1986.8, 173.1e-7
PIVEM = {
    name: (row[:7], row[7], row[8]) for name, row in rows_of("pivem_exact.csv").items()
}

# L, flux_fluid, flux_solid, d_fluid, d_solid, ha, d_cross. At unit flux and length ha
# is NTU and 1/d the Peclet number.
EXTREME = rows_of("extreme_heat.csv")
STATIONS = np.concatenate(
    [
        [0.0, 1e-6, 1e-4, 1e-2],
        np.linspace(0.05, 0.95, 19),
        [0.99, 1.0 - 1e-4, 1.0 - 1e-6, 1.0],
    ]
)


def bed(u_d, slip, diameter, porosity, reynolds, capacity, conductivity):
    """Coefficients of Eqs. 11, 12 with a_i = 4 (1 - phi)/D, Eq. 20 and Table 2 as
    printed.
    """
    c_fluid = RHO_FLUID * CP_FLUID
    prandtl = MU_FLUID * CP_FLUID / K_FLUID
    nusselt = (
        1.0
        + 4.0 * (1.0 - porosity) / porosity
        + 0.5 * np.sqrt(1.0 - porosity) * reynolds * prandtl ** (1 / 3)
    )
    ha = nusselt * K_FLUID / diameter * 4.0 * (1.0 - porosity) / diameter
    d_solid = (1.0 - porosity) * conductivity * K_FLUID
    return (
        c_fluid * u_d,
        capacity * c_fluid * slip * u_d,
        porosity * K_FLUID,
        d_solid,
        ha,
    )


@pytest.mark.parametrize("name", PIVEM)
def test_pivem_equilibrium_and_length(name):
    """All six printed digits; the reference lengths of the conductivity rows were
    not recorded.
    """
    row, equilibrium, length = PIVEM[name]
    lam, r = exact.decay_rate(*bed(*row))
    assert 1.0 / (1.0 - r) == approx(equilibrium, abs=5.1e-7)
    if length is not None:
        assert np.log(100.0) / lam == approx(length, abs=5.1e-7)


def test_mixing_value_differs_from_equilibrium():
    """Prescribed inlet temperatures let heat conduct in: equilibrium lies above the
    ratio of the convective fluxes.
    """
    _, r = exact.decay_rate(*bed(*PIVEM["reynolds_10"][0]))
    assert 1.0 / (1.0 - r) - 0.75 / 1.75 == approx(0.448666 - 0.428571, abs=1e-6)


@pytest.mark.parametrize("name", EXTREME)
def test_finite_length_boundary_conditions(name):
    """Inlet values to 4e-15. Outlet slopes to 1e-13 of the largest slope or of a
    unit temperature over L.
    """
    length, c_f, c_s, d_f, d_s, *rest = EXTREME[name]
    x = STATIONS * length
    f, s = exact.finite_length(x, length, c_f, c_s, d_f, d_s, *rest)
    df, ds = exact.finite_length(x, length, c_f, c_s, d_f, d_s, *rest, derivative=1)
    inlet, outlet = (0, -1) if c_s >= 0 else (-1, 0)
    assert abs(f[0]) < 4e-15
    if c_s or d_s:
        assert abs(s[inlet] - 1.0) < 4e-15
    if d_f:
        assert abs(df[-1]) < 1e-13 * max(np.abs(df).max(), 1.0 / length)
    if d_s:
        assert abs(ds[outlet]) < 1e-13 * max(np.abs(ds).max(), 1.0 / length)


def test_long_bed_approaches_semi_infinite():
    """A bed of 40 decay lengths: exp(-40) = 4e-18 is left at the outlet, so only
    round-off (1e-14) differs upstream.
    """
    coefficients = bed(*PIVEM["reynolds_50"][0])
    lam, _ = exact.decay_rate(*coefficients)
    x = np.linspace(0.0, 20.0 / lam, 50)
    assert_allclose(
        exact.finite_length(x, 40.0 / lam, *coefficients),
        exact.semi_infinite(x, *coefficients),
        atol=1e-14,
    )


def test_semi_infinite_at_huge_distance_and_without_solid_inlet():
    """No overflow at lam x = 1e6; a solid that neither moves nor conducts takes the
    fluid's temperature at once.
    """
    f, s = exact.semi_infinite(np.array([0.0, 1e6]), 1.0, 1.0, 0.0, 0.0, 0.5)
    assert_array_equal([f, s], [[0.0, 0.5], [1.0, 0.5]])
    f, s = exact.semi_infinite([0.0, 1e-9, 1.0], 1.0, 0.0, 0.1, 0.0, 10.0)
    assert_array_equal([f, s], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])


def test_impossible_coefficients_are_refused():
    for bad in (
        (-1.0, 1.0, 0.1, 0.1, 1.0),
        (1.0, 1.0, -0.1, 0.1, 1.0),
        (1.0, 1.0, 0.1, 0.1, 0.0),
    ):
        with pytest.raises(ValueError, match="two-energy solution"):
            exact.rates(*bad)
    with pytest.raises(ValueError, match="d_cross"):
        exact.rates(1.0, 1.0, 0.1, 0.1, 1.0, 0.2)
    with pytest.raises(ValueError, match="counter-current"):
        exact.decay_rate(1.0, -1.0, 0.1, 0.1, 1.0)


def test_nakayama():
    """Pivem's Table 1 (k_s/k_f = 40, porosity 0.4, K_xx/k_f = 50) with Pr of Table
    2: all recorded digits, 1e-8.
    """
    tortuosity = exact.tortuosity_parameter(0.4, 40.0)
    peclet = exact.nakayama_peclet(100.0, MU_FLUID * CP_FLUID / K_FLUID, 0.4)
    coefficients = exact.nakayama_coefficients(peclet, 0.4, 40.0, 50.0, tortuosity)
    lam, r = exact.decay_rate(**coefficients)
    assert tortuosity == approx(-0.01321964, abs=5e-9)
    assert tortuosity * 39.0**2 + 0.4 + 0.6 * 40.0 == approx(4.2929334, abs=5e-8)
    assert peclet == approx(11.951048, abs=5e-7)
    assert lam == approx(0.60922966, abs=5e-9)
    assert 1.0 / (1.0 - r) == approx(0.04569593, abs=5e-9)
    f, s = exact.semi_infinite([0.0, 1e3], **coefficients)
    assert_allclose(
        [1.0 - f, 1.0 - s], [[1.0, 0.95430407], [0.0, 0.95430407]], atol=5e-9
    )


# Patil et al., heated bed of copper spheres in water: u [m/s], A [1/s], B [1/s].
SCHUMANN_A = (0.20169758196457, 3.5576862041633, 4.5291839336383)


def test_schumann_published():
    """Bed A at t = 2.25 s, z = 0.1, 0.2, 0.25, 0.3 m: all eight recorded digits."""
    f, s = exact.schumann([0.1, 0.2, 0.25, 0.3], 2.25, *SCHUMANN_A)
    assert_allclose(f, [0.98902260, 0.81327151, 0.58935161, 0.32609428], atol=5e-9)
    assert_allclose(s, [0.97293030, 0.70894060, 0.45448543, 0.21209334], atol=5e-9)


def test_a_store_of_rock_whose_voids_are_filled_often():
    """A stream that fills the voids 4600 times in four hours."""
    text = """
mesh = { type = "line", length = 1.5 }
gas = { density = 1.1, viscosity = 2e-5, heat_capacity = 1008.0, conductivity = 0.03 }
solids.rock = { density = 2600.0, heat_capacity = 850.0, conductivity = 2.0, diameter = 0.03, inside.heat = "lumped" }
packed_bed.porosity = 0.42
closures = { nusselt = 30.0, conductivity_gas = 0.0, conductivity_solids = 0.0 }
heat = {}
boundary.left.gas = { velocity = 0.2, temperature = 343.15 }
initial = { gas.temperature = 293.15, solids.rock.temperature = 293.15 }
time = { end = 14400.0, times = [3600.0, 10800.0] }
output.positions = [1.5]
"""
    found = cb.run(loads(text))
    exchange = 30.0 * 0.03 / 0.03 * 6.0 * 0.58 / 0.03
    rates = exchange / (0.42 * 1.1 * 1008.0), exchange / (0.58 * 2600.0 * 850.0)
    fluid, _ = exact.schumann(
        1.5, np.array([3600.0, 10800.0, 14400.0]), 0.2 / 0.42, *rates
    )
    # quadratures of the reference
    assert found.profiles["theta_fluid [1]"] == approx(fluid, abs=1e-9)
    assert_closed(found, 1e-12, "energy")


def test_schumann_limits():
    """Nothing ahead of the front, exp(-A z/u) just behind it, the inlet's own solid
    1 - exp(-B t), all hot at last.
    """
    u, a, b = SCHUMANN_A
    z = np.array([[0.1], [0.3]])
    f, s = exact.schumann(z, np.array([0.0, 0.4, 1e3]), u, a, b)
    assert f.shape == s.shape == (2, 3)
    assert_array_equal(f[:, 0], 0.0)
    assert_array_equal(s[:, 0], 0.0)
    assert_allclose([f[:, 2], s[:, 2]], 1.0, atol=1e-14)
    assert_allclose(
        exact.schumann(0.5, 0.5, 1.0, 7.0, 2.0), [np.exp(-3.5), 0.0], atol=1e-15
    )
    assert_allclose(
        exact.schumann(0.0, 0.25, u, a, b), [1.0, -np.expm1(-b / 4.0)], atol=1e-15
    )


@pytest.mark.parametrize("losses", [(0.0, 0.0), (300.0, 0.0), (0.0, 50.0), (2e3, 1e3)])
def test_relaxation_is_the_matrix_exponential(losses):
    """1e-12 of the temperature scale, the accuracy of expm."""
    capacity, ha, start, ambient = (
        np.array([900.0, 2.1e3]),
        1.7e3,
        np.array([300.0, 450.0]),
        280.0,
    )
    matrix = (
        np.diag([ha + losses[0], ha + losses[1]]) - ha * np.eye(2)[::-1]
    ) / capacity[:, None]
    for t in (0.0, 0.1, 3.0, 50.0):
        expected = ambient + expm(-matrix * t) @ (start - ambient)
        computed = exact.two_temperature_relaxation(
            t, *capacity, ha, *start, *losses, ambient
        )
        assert_allclose(computed, expected, rtol=1e-12)


def test_fin_is_the_limit_of_infinite_fluid_flux():
    """flux = 1e12: the fluid stays at zero to 1e-9. Ends: s(0) = 1, s(L) = 1/cosh(m
    L).
    """
    x = np.linspace(0.0, 0.3, 13)
    s = exact.fin(x, 0.3, 2.0, 500.0)
    assert_allclose(
        s, exact.finite_length(x, 0.3, 1e12, 0.0, 0.1, 2.0, 500.0)[1], atol=1e-9
    )
    assert_allclose(s[[0, -1]], [1.0, 1.0 / np.cosh(0.3 * np.sqrt(250.0))], rtol=1e-15)


# Pivem slip row: H, u_D, mu, rho, K = Da H^2 with the printed Da, porosity; c_F (Ward)
# is not in the paper.
HEIGHT, U_MEAN, PERMEABILITY, POROSITY, WARD = (
    0.0775,
    0.2833,
    0.003371 * 0.0775**2,
    0.9,
    0.55,
)


def channel(y, slip, forchheimer, height=HEIGHT, permeability=PERMEABILITY):
    bed_velocity = slip * U_MEAN
    return exact.brinkman_forchheimer_channel(
        y,
        height,
        U_MEAN,
        bed_velocity,
        MU_FLUID,
        RHO_FLUID,
        permeability,
        forchheimer,
        POROSITY,
    )


@pytest.mark.parametrize(
    ("slip", "forchheimer", "peak", "gradient"),
    [
        (0.0, 0.0, 1.13882860484, -304.220213669),
        (0.0, WARD, 1.02258988973, -5186.27483203),
        (0.5, WARD, 1.03420491277, -1483.48100097),
        (0.95, WARD, 1.05824569991, -83.9537394),
        (-0.25, WARD, 1.01986575808, -7915.77361637),
    ],
)
def test_channel_published(slip, forchheimer, peak, gradient):
    """All recorded digits: 6e-12 of u_max/u_D and 1e-9 of d(phi <p>)/dx H^2/(mu
    u_D).
    """
    result = channel(0.0, slip, forchheimer)
    assert result.u_max / U_MEAN == approx(peak, abs=6e-12)
    assert result.pressure_gradient * HEIGHT**2 / (MU_FLUID * U_MEAN) == approx(
        gradient, rel=1e-9
    )


@pytest.mark.parametrize("darcy", [1e-8, 1e-5, 1e-3, 10.0])
@pytest.mark.parametrize("slip", [-5.0, 0.0, 0.5, 0.95, 1.0, 1.05, 3.0])
def test_channel_extremes(slip, darcy):
    """No slip and the mean velocity from beds of pure plug to an open channel; 1e-9,
    Gauss's rule in graded panels.
    """
    edges = HEIGHT / 2.0 * np.concatenate([[0.0], 2.0 ** np.arange(-40.0, 1.0)])
    nodes, weights = np.polynomial.legendre.leggauss(20)
    half = 0.5 * np.diff(edges)[:, None]
    result = channel(
        edges[:-1, None] + half * (1.0 + nodes),
        slip,
        WARD,
        permeability=darcy * HEIGHT**2,
    )
    assert np.sum(half * weights * result.u) == approx(U_MEAN * HEIGHT / 2.0, rel=1e-9)
    walls = channel(
        np.array([0.0, HEIGHT]), slip, WARD, permeability=darcy * HEIGHT**2
    ).u
    assert_allclose(walls, 0.0, atol=1e-14)


def test_channel_without_inertia_is_the_limit():
    """c_F = 1e-13 goes through the spectral solver, c_F = 0 through cosh: 1e-11 of
    the mean velocity.
    """
    y = np.linspace(0.0, HEIGHT, 31)
    assert_allclose(
        channel(y, 0.5, 1e-13).u, channel(y, 0.5, 0.0).u, atol=1e-11 * U_MEAN
    )


def test_channel_refuses_impossible_data():
    with pytest.raises(ValueError, match="channel flow"):
        exact.brinkman_forchheimer_channel(
            0.0, 1.0, -1.0, 0.0, 1e-5, 1.0, 1e-6, 0.5, 0.4
        )


def test_third_order_where_the_conductivity_depends_on_temperature():
    """Conduction and radiation in a counter-current bed (Zehner, Bauer, Schluender)
    with quadratic elements: the difference from 320 cells falls with an order above 2.6
    from 40 to 80 cells, and is below 3e-5 of the span on 80.
    """
    places = np.linspace(0.0, 1.0, 41)

    def theta(cells):
        scene = from_dict(
            scene_of(
                """
                [mesh]
                type = "line"
                length = 1.0
                [gas]
                density = 1.2
                heat_capacity = 1000.0
                conductivity = 0.05
                viscosity = 1.8e-5
                [solids.particles]
                density = 2000.0
                heat_capacity = 900.0
                conductivity = 1.0
                diameter = 0.02
                [packed_bed]
                porosity = 0.4
                [closures]
                nusselt = 2.0
                conductivity_gas = 0.05
                conductivity_solids.name = "zehner_bauer_schluender"
                conductivity_solids.emissivity = 0.8
                [heat]
                [boundary.left]
                gas.velocity = 0.05
                gas.temperature = 300.0
                [boundary.right]
                solids.particles.velocity = 1e-4
                solids.particles.temperature = 1300.0
                """,
                {"mesh.cells": cells, "output.positions": list(places)},
            )
        )
        profiles = cb.run(scene).profiles
        return np.concatenate(
            [profiles["theta_fluid [1]"], profiles["theta_solid [1]"]]
        )

    finest = theta(320)
    coarse, fine = (np.abs(theta(cells) - finest).max() for cells in (40, 80))
    assert np.log2(coarse / fine) > 2.6 and fine < 1.2e-4
