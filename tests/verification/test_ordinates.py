"""Discrete ordinates against exact transport, closed forms, limits and identities of
the discrete equations.

Meshes grow from `first` optical depths at the walls, so that the error of the
directions is what remains. Identities of the discrete system (balances, reciprocity,
symmetry) hold to round-off, taken as 1e-12 of the largest term.
"""

import numpy as np
import pytest
from pytest import approx
from scipy.special import expn

import contbed as cb
from contbed.closures.optics import SIGMA
from contbed.errors import ConvergenceError
from contbed.loading import from_dict
from contbed.radiation.equations.ordinates import Ordinates, Wall
from studies._exact.radiation import (
    TWO_FLUX,
    equilibrium_flux,
    gray_plates,
    linear_slab,
)
from studies._exact.transport import Equilibrium, half_space_emittance, slab_emittance
from tests.scene_text import scene_of
from tests.verification.one_emission import solve_ordinates

HOT, COLD = Wall(1.0), Wall(0.0)


def graded(tau: float, first: float = 0.02, growth: float = 1.2) -> np.ndarray:
    """Nodes on 0 ... tau whose spacing grows from both ends."""
    first = min(first, 0.05 * tau)
    count = int(np.ceil(np.log1p(0.5 * tau / first * (growth - 1.0)) / np.log(growth)))
    half = np.concatenate([[0.0], np.cumsum(growth ** np.arange(count))])
    half *= 0.5 * tau / half[-1]
    return np.concatenate([half, tau - half[-2::-1]])


@pytest.mark.parametrize(
    ("order", "percent"), [(2, 0.78), (4, 0.06), (8, 0.004), (24, 1e-4)]
)
def test_heaslet_warming(order, percent):
    """Psi of black plates over four decades of thickness, in per cent of exact
    transport; 2 + 2 is worst at 0.4.
    """
    errors = []
    for tau in (0.01, 0.1, 0.4, 1.0, 10.0, 100.0):
        solution = solve_ordinates(
            graded(tau), 0.4, 0.6, None, HOT, COLD, order, degree=3
        )
        assert np.ptp(solution.q) < 1e-12
        errors.append(100.0 * abs(solution.q[0] / Equilibrium(tau).flux - 1.0))
    assert max(errors) < percent


def test_profile_of_black_plates():
    tau = 1.0
    solution = solve_ordinates(
        graded(tau, 1e-3), 1.0, 0.0, None, HOT, COLD, order=16, degree=3
    )
    inside = (solution.points > 0.02) & (solution.points < 0.98)
    # next to the walls the slope is infinite; 16 directions see it from 0.02 mean free
    # paths
    assert 0.25 * solution.G[inside] == approx(
        Equilibrium(tau).profile(solution.points[inside]), abs=3e-5
    )
    assert 1.0 - 0.25 * solution.G[0] == approx(Equilibrium(tau).slip, abs=1e-3)


@pytest.mark.parametrize(
    ("albedo", "tau"),
    [(0.0, 0.5), (0.5, 1.0), (0.9, 10.0), (0.99, 100.0)],
    ids=lambda value: f"{value:g}",
)
def test_isothermal_slab_converges_to_transport(albedo, tau):
    exact = slab_emittance(tau, albedo)
    z = graded(tau, 1e-3, 1.3)
    errors = []
    for order in (2, 4, 8, 16):
        solution = solve_ordinates(
            z, 1.0 - albedo, albedo, 1.0 - albedo, COLD, COLD, order, degree=4
        )
        errors.append(abs(solution.q[-1] / exact - 1.0))
    # each doubling gains a factor of 12 to 210, here: the integrand exp(-tau/mu) is
    # smooth, but not analytic, at mu = 0
    assert errors[1] < 1e-3 and errors[3] < 1e-7
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 3.0)


def test_observed_order_in_cells():
    """Degree p: the flux at the walls and G at the nodes converge with 2 p."""
    tau, order = 2.0, 3

    def solve(cells: int, degree: int):
        z = np.linspace(0.0, tau, cells + 1)
        return solve_ordinates(
            z,
            lambda z: 0.3 + 0.1 * z,
            0.5,
            lambda z: 1.0 + np.sin(z),
            HOT,
            COLD,
            order,
            degree,
        )

    reference = solve(64, 6)
    for degree, cells in ((1, (16, 32, 64)), (2, (8, 16, 32)), (3, (8, 16, 32))):
        flux, field = [], []
        for count in cells:
            solution = solve(count, degree)
            flux.append(abs(solution.q[0] - reference.q[0]))
            at = solution.z
            field.append(
                np.abs(
                    solution.G[::degree] - np.interp(at, reference.z, reference.G[::6])
                ).max()
            )
        assert np.log2(flux[-2] / flux[-1]) == approx(2 * degree, abs=0.35)
        assert np.log2(field[-2] / field[-1]) > 2 * degree - 0.35


@pytest.mark.parametrize("emissivity", [(1.0, 1.0), (0.3, 0.8), (1.0, 0.05)])
@pytest.mark.parametrize("tau", [0.1, 1.0, 30.0])
def test_one_ordinate_is_the_two_flux_model(tau, emissivity):
    left, right = Wall(2.0, emissivity[0]), Wall(0.5, emissivity[1])
    z = np.linspace(0.0, tau, 60)
    plates = solve_ordinates(z, 0.3, 0.7, None, left, right, order=1)
    # G is linear and the elements hold it exactly
    assert plates.q == approx(
        1.5 * equilibrium_flux(tau, TWO_FLUX, emissivity), rel=1e-12
    )
    graded_z = graded(tau, 0.01)
    medium = solve_ordinates(
        graded_z,
        0.8,
        0.2,
        lambda z: 0.8 * (1.0 + z / tau),
        left,
        right,
        order=1,
        degree=5,
    )
    G, q = linear_slab(graded_z, tau, TWO_FLUX, (1.0, 2.0), (2.0, 0.5), 0.2, emissivity)
    assert medium.G[::5] == approx(G, abs=1e-9)
    assert medium.q == approx(q, abs=1e-9)


@pytest.mark.parametrize("emissivity", [(0.3, 0.8), (0.01, 1.0), (1e-6, 1e-6)])
@pytest.mark.parametrize("order", [1, 4])
def test_gray_plates_are_exact_at_any_order(order, emissivity):
    """Psi/(1 + Psi (1/e1 + 1/e2 - 2)): the half range integrates mu exactly, so
    walls add resistance as they should.
    """
    z = graded(1.0)
    black = solve_ordinates(z, 1.0, 0.0, None, HOT, COLD, order).q[0]
    gray = solve_ordinates(
        z, 1.0, 0.0, None, Wall(1.0, emissivity[0]), Wall(0.0, emissivity[1]), order
    ).q[0]
    # the walls' own balance has lost 1/e of the 16 digits
    assert gray == approx(
        gray_plates(black, emissivity), rel=1e-12 + 1e-14 / min(emissivity)
    )


def test_albedo_towards_one():
    """Absorption 1 - omega of a bed of thickness 1000 moves its flux by about
    (1 - omega) tau^2, 1e-9 to 1e-3 here.
    """
    z = graded(1e3)
    limit = solve_ordinates(z, 0.0, 1.0, 0.0, HOT, COLD).q[0]
    for albedo in (1.0 - 1e-9, 1.0 - 1e-12, 1.0 - 1e-15):
        q = solve_ordinates(z, 1.0 - albedo, albedo, 0.0, HOT, COLD).q
        assert 0.0 < q[0] / limit - 1.0 < 2.0 * (1.0 - albedo) * 1e6 + 1e-10


def test_thick_limit():
    """Rosseland: q = -4/3 d(sigma T^4)/dt; black plates differ by their slips, 2 x
    0.7104 mean free paths in all.
    """
    for tau in (1e2, 1e3, 1e5):
        q = solve_ordinates(graded(tau), 0.5, 0.5, None, HOT, COLD).q[0]
        assert q == approx(4.0 / 3.0 / (tau + 1.420892), rel=2e-5)
    emitted = solve_ordinates(graded(400.0), 0.5, 0.5, 0.5, COLD, COLD, order=8).q[-1]
    assert emitted == approx(half_space_emittance(0.5), rel=1e-5)


def test_thin_limit():
    """Emission leaves both sides alike and unabsorbed; thin cells cost no digits."""
    z = np.linspace(0.0, 1.0, 31)
    for tau in (1e-3, 1e-6, 1e-9):
        emitting = solve_ordinates(z, tau, 0.0, tau, COLD, COLD)
        assert emitting.q[-1] == approx(2.0 * tau, rel=6.0 * tau + 1e-7)
        assert emitting.q[0] == approx(-emitting.q[-1], rel=1e-10)
        assert solve_ordinates(z, tau, 0.0, None, HOT, COLD).q == approx(
            1.0 - tau, abs=4.0 * tau**2 + 1e-13
        )
    with pytest.raises(ConvergenceError, match="optical depth above 1e-12"):
        solve_ordinates(z, 1e-15, 0.0, 1e-15, COLD, COLD)


def test_balance_of_each_cell():
    """q[i+1] - q[i] = int (4 e - Ka G), by an independent quadrature, with steps of
    four decades in Ka and Ks.
    """
    rng = np.random.default_rng(3)
    z = np.cumsum(rng.uniform(0.01, 1.0, 40))
    Ka, Ks = 10.0 ** rng.uniform(-2.0, 2.0, (2, 39))
    e = rng.uniform(0.0, 5.0, 40)
    solution = solve_ordinates(z, Ka, Ks, e, Wall(2.0, 0.3), Wall(1.0, 0.6))
    dz = np.diff(z)
    G = (solution.G[:-1:2] + 4.0 * solution.G[1::2] + solution.G[2::2]) / 6.0
    gain = dz * (2.0 * (e[:-1] + e[1:]) - Ka * G)
    assert np.diff(solution.q) == approx(gain, abs=1e-12 * np.abs(dz * Ka * G).max())
    assert solution.q[-1] - solution.q[0] == approx(gain.sum(), rel=1e-12, abs=1e-12)
    # walls: J = e E + (1 - e) (incoming), with the incoming flux from the intensities
    # themselves
    for wall, leaving, incoming in (
        (Wall(2.0, 0.3), solution.I_plus[:, 0], solution.I_minus[:, 0]),
        (Wall(1.0, 0.6), solution.I_minus[:, -1], solution.I_plus[:, -1]),
    ):
        flux = 2.0 * np.pi * solution.weight * solution.mu @ incoming
        radiosity = wall.emissivity * wall.power + (1.0 - wall.emissivity) * flux
        assert np.pi * leaving == approx(radiosity, rel=1e-12)


def test_intensities_and_moments():
    solution = solve_ordinates(graded(2.0), 0.4, 0.6, 0.4 * 3.0, Wall(2.0), COLD)
    both, net = solution.I_plus + solution.I_minus, solution.I_plus - solution.I_minus
    assert solution.G[::2] == approx(2.0 * np.pi * solution.weight @ both, rel=1e-13)
    assert solution.q == approx(
        2.0 * np.pi * (solution.weight * solution.mu) @ net, abs=1e-13
    )
    pure = solve_ordinates(graded(2.0, 0.001), 1.0, 0.0, 3.0, Wall(2.0), COLD, degree=4)
    beam = 3.0 - np.exp(-pure.z / pure.mu[:, None])
    assert np.pi * pure.I_plus == approx(beam, abs=1e-9)


def test_response():
    """The affine map equals the solve; its load form is symmetric, so that i heats k
    as k heats i.
    """
    z = graded(3.0)
    bed = Ordinates(z, lambda z: 0.5 + 0.2 * z, 0.8, Wall(1.5, 0.7), COLD)
    R, G0 = bed.response()
    e = 1.0 + np.cos(bed.points)
    assert R @ e + G0 == approx(bed.solve(e).G, rel=1e-12)
    exchange = bed.mass_matrix() @ R
    assert exchange == approx(exchange.T, abs=1e-14)
    solution = bed.solve(e)
    absorbed = bed.mass_matrix(lambda z: 0.5 + 0.2 * z) @ solution.G
    emitted = 4.0 * (bed.mass_matrix() @ e)
    assert (emitted - absorbed).sum() == approx(
        solution.q[-1] - solution.q[0], rel=1e-12
    )


def test_walls_exchange_alike():
    """Heat from left to right wall equals that from right to left, through layers
    and past gray surfaces.
    """
    Ka, Ks, z = (
        np.array([0.2, 3.0, 0.7]),
        np.array([1.0, 0.1, 4.0]),
        [0.0, 0.4, 0.9, 2.0],
    )
    one = solve_ordinates(z, Ka, Ks, 0.0, Wall(1.0, 0.3), Wall(0.0, 0.8)).q[-1]
    other = solve_ordinates(z, Ka, Ks, 0.0, Wall(0.0, 0.3), Wall(1.0, 0.8)).q[0]
    assert one == approx(-other, rel=1e-12)


def test_ways_to_give_coefficients():
    z = np.array([0.0, 0.3, 1.0, 1.2])
    ways = [
        0.5,
        lambda z: 0.5 + 0.0 * z,
        np.full(4, 0.5),
        np.full(3, 0.5),
        np.full(7, 0.5),
    ]
    fields = [solve_ordinates(z, way, 1.0, way, HOT, COLD) for way in ways]
    for field in fields[1:]:
        np.testing.assert_allclose(field.G, fields[0].G, rtol=1e-13)
    linear, function = 0.1 + z, lambda z: 0.1 + z
    first = solve_ordinates(z, linear, 1.0, linear, HOT, COLD)
    np.testing.assert_allclose(
        solve_ordinates(z, function, 1.0, function, HOT, COLD).G, first.G, rtol=1e-13
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"z": [0.0, 2.0, 1.0]}, "increasing order"),
        ({"Ka": -0.1}, "Ka >= 0"),
        ({"Ka": 0.0, "Ks": 0.0}, "Ka \\+ Ks > 0"),
        ({"Ka": np.nan}, "Ka must be finite"),
        ({"Ks": np.ones(9)}, "Ks has the shape"),
        ({"degree": 0}, "degree"),
        ({"Ka": 0.0, "left": Wall(1.0, 0.0), "right": None}, "absorbs"),
    ],
)
def test_errors(change, message):
    given = {
        "z": [0.0, 1.0, 2.0],
        "Ka": 1.0,
        "Ks": 1.0,
        "emission": 1.0,
        "left": HOT,
        "right": COLD,
    }
    with pytest.raises(ValueError, match=message):
        solve_ordinates(**(given | change))


def test_errors_of_walls():
    with pytest.raises(ValueError, match="emissivity"):
        Wall(1.0, 1.2)


@pytest.mark.parametrize("tau", [0.02, 0.5, 3.0])
def test_the_number_of_ordinates_follows_the_error(tau):
    """An emitting slab: G = 2 sigma T^4 (2 - E2(t) - E2(tau - t)) and q = 2 sigma T^4
    (1/2 - E3(tau)) at its ends.

    The true errors stay below 1.2 times the estimate, whose rule is that of many
    ordinates, and the estimate below the tolerance unless a warning says that no more
    were tried.
    """
    scene = scene_of(
        """
        [mesh]
        type = "line"
        length = 0.1
        [radiation]
        level = "ordinates"
        scattering = 0.0
        temperature = 1000.0
        [boundary.left]
        radiation.radiosity = 0.0
        [boundary.right]
        radiation.radiosity = 0.0
        [solver]
        tolerance = 1e-4
        [output]
        plots = false
        fields = false
        positions = [0.0, 0.02, 0.05]
        """,
        {"radiation.absorption": tau / 0.1},
    )
    result = cb.run(from_dict(scene))
    black = SIGMA * 1000.0**4
    t = tau * result.profiles["x [m]"] / 0.1
    G = 2.0 * black * (2.0 - expn(2, t) - expn(2, tau - t))
    estimate = result.qoi["estimated_error_angles"]
    assert np.abs(result.profiles["G [W/m2]"] - G).max() <= 1.2 * estimate * G.max()
    flux = 2.0 * black * (0.5 - expn(3, tau))
    assert -result.qoi["heat_left_W"] == approx(flux, rel=1.2 * estimate)
    assert (estimate <= 1e-4) == (not result.warnings)
    assert result.qoi["ordinates"] in (8, 16, 32, 64)
    given = cb.run(
        from_dict(scene | {"radiation": scene["radiation"] | {"ordinates": 4}})
    )
    assert "ordinates" not in given.qoi
    assert abs(given.qoi["heat_left_W"] + flux) > 10.0 * abs(
        result.qoi["heat_left_W"] + flux
    )
