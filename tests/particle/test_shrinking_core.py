"""One interface: times, rates and their agreement."""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx
from scipy.integrate import solve_ivp

from contbed.chemistry.laws import shrinking_core as core
from contbed.fem.ad.dual import Dual
from tests.particle.tables import rows


def time(X, tau):
    """Time at which a conversion is reached, in constant gas."""
    q = (1.0 - X) ** (1.0 / 3.0)
    gone = X / (1.0 + q + q * q)  # 1 - q without cancellation
    return tau.film * X + tau.ash * gone * gone * (1.0 + 2.0 * q) + tau.reaction * gone


@pytest.mark.parametrize("row", rows("shrinking_core_time.csv"))
def test_times(row):
    tau = core.Times(row["tau_film"], row["tau_ash"], row["tau_reaction"])
    # 12 digits less those lost at small X
    assert time(row["X"], tau) == approx(row["t"], rel=5e-11)


@pytest.mark.parametrize(
    "tau", [(0.2, 0.5, 0.3), (1.0, 0.0, 0.1), (0.0, 2.0, 0.01), (0.0, 0.0, 1.0)]
)
def test_speed_of_the_interface_integrates_to_the_time(tau):
    tau = core.Times(*tau)
    q = np.array([0.9, 0.5, 0.1])
    found = solve_ivp(lambda x, t: 1.0 / core.per_area(1.0 - x, tau), (0, 0.9), [0.0], rtol=1e-11, atol=1e-13,
                      t_eval=1.0 - q)  # fmt: skip
    # of the integrator
    assert found.y[0] == approx(time(1.0 - q**3, tau), rel=1e-9)


def test_rate_is_that_of_the_interface_and_finite_at_the_end():
    tau = core.Times(0.2, 0.5, 0.3)
    q = np.array([1.0, 0.4, 0.0])
    assert core.rate(q, tau) == approx(3 * q**2 * core.per_area(q, tau), rel=1e-14)
    assert core.rate(0.0, tau) == 0.0
    assert core.per_area(0.0, tau) == approx(1 / 0.3)
    assert core.rate(1.0, tau) == approx(3.0 / (3 * 0.2 + 0.3), rel=1e-14)


def test_times_of_the_resistances():
    tau = core.times(
        2e-3, 2e4, 5.0, gas_per_solid=3.0, film=0.1, diffusivity=1e-5, constant=0.02
    )
    assert tau.film == approx(3 * 2e-3 * 2e4 / (3 * 0.1 * 5.0))
    assert tau.ash == approx(3 * 4e-6 * 2e4 / (6 * 1e-5 * 5.0))
    assert tau.reaction == approx(3 * 2e-3 * 2e4 / (0.02 * 5.0))


def test_fractional_powers_are_odd_straight_lines_at_the_end():
    assert core.remaining_radius(np.array([-1e-9, 0.0]))[0] == approx(
        -1e-9 * 1e4, rel=1e-5
    )
    assert core.remaining_radius(0.125) == approx(0.5, rel=1e-10)


def test_derivatives_by_dual_numbers():
    tau = core.Times(0.2, 0.5, 0.3)

    def slope(left):
        return core.rate(
            core.remaining_radius(Dual(np.array([left]), {"n": np.ones(1)})), tau
        ).tangents["n"][0]

    for left in (1e-7, 0.4, 1.0):
        step = 1e-4 * max(left, core.SMALL)
        up, down = (
            float(core.rate(core.remaining_radius(left + s), tau))
            for s in (step, -step)
        )
        # differences of order step^2
        assert slope(left) == approx((up - down) / (2 * step), rel=1e-6, abs=1e-6)
    assert slope(0.0) == 0.0  # as of q |q|


def test_a_negative_rest_recovers():
    """The rate is odd in the radius of the interface: cells of a bed that overshoot
    the end come back to it.
    """
    q, tau = np.array([1e-3, 0.1, 0.4]), core.Times(0.2, 0.5, 0.3)
    np.testing.assert_allclose(core.rate(-q, tau), -core.rate(q, tau), rtol=1e-14)
    assert np.all(core.rate(-q, tau) < 0.0)
