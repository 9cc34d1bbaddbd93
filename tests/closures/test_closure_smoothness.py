"""Every closure is finite, free of jumps and kinks, and carries dual numbers to the
right slope.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx

from contbed import closures
from contbed.fem.ad.dual import Dual
from tests.numbers_of import rows_of

# One box of sensible values for each standard argument name.
BOX = rows_of("closure_arguments.csv")
# zero or almost on a part of the line: differences of terms, an exponential of -5.4 u_t
# / u, drag of which clusters leave a thousandth
VANISHES = {
    closures.bubble_fraction_kunii_levenspiel,
    closures.bubble_fraction_two_phase,
    closures.bubble_growth_horio_nonaka,
    closures.bubble_growth_mori_wen,
    closures.drag_milioli,
    closures.elutriation_colakyan_levenspiel,
    closures.elutriation_geldart,
    closures.emulsion_gas_kunii_levenspiel,
    closures.friction_johnson_jackson,
}
ALL = [closures.get(name) for name in closures.names()]
MOST_ARGUMENTS = 14


def between(name, share):
    """Between the ends of the box of an argument, on a logarithmic scale."""
    low, high = BOX[name]
    return low * (high / low) ** share


def point(function, shares):
    return {
        name: between(name, share)
        for name, share in zip(function.sheet.arguments, shares, strict=False)
    }


def points(function, count, seed):
    """Random points of the box (count, 1) of each argument, a sixth of their
    coordinates at its ends.
    """
    drawn = np.random.default_rng(seed).uniform(-0.1, 1.1, (MOST_ARGUMENTS, count, 1))
    return point(function, np.clip(drawn, 0.0, 1.0))


def slope(function, arguments, name):
    """Slope to an argument, by a dual number in its place."""
    found = function(**{**arguments, name: Dual(arguments[name], {name: 1.0})})
    return found.tangents.get(name, 0.0) if isinstance(found, Dual) else 0.0


def difference(function, arguments, name, step):
    high, low = (
        function(**{**arguments, name: arguments[name] * (1 + sign * step)})
        for sign in (1, -1)
    )
    return (high - low) / (2 * step * arguments[name])


@pytest.mark.parametrize("function", ALL, ids=lambda function: function.__name__)
def test_dual_numbers_give_the_slope(function):
    arguments = points(function, 200, seed=1)
    value = function(**arguments)
    assert np.isfinite(value).all()
    for name in arguments:
        exact, estimate = (
            slope(function, arguments, name),
            difference(function, arguments, name, 1e-5),
        )
        # A central difference with step 1e-5 is good to 1e-9; conditioning costs up to
        # three digits more.
        allowed = 1e-6 * np.maximum(abs(estimate), abs(value / arguments[name]))
        assert (abs(exact - estimate) <= allowed).all()


@pytest.mark.parametrize("function", ALL, ids=lambda function: function.__name__)
def test_no_nan_no_jump_no_kink_along_any_argument(function):
    arguments = points(function, 25, seed=2)
    for name in arguments:
        line = between(name, np.linspace(0, 1, 4001))
        values = function(**{**arguments, name: line})
        values = np.broadcast_to(
            values, np.broadcast_shapes((25, 1), np.shape(values), line.shape)
        )
        assert np.all(np.isfinite(values))
        # Neighbours differ by 0.25 % at most, so the second difference of a smooth
        # function, even of a cube, stays below 1e-4 of it, while a jump or a kink shows
        # in first order.
        scale = np.maximum(np.abs(values[:, :-2]), np.abs(values[:, 2:]))
        if function in VANISHES:
            scale = np.abs(values).max(axis=1, keepdims=True)
        assert np.all(
            np.abs(values[:, :-2] - 2 * values[:, 1:-1] + values[:, 2:]) <= 1e-4 * scale
        )


@pytest.mark.parametrize("function", ALL, ids=lambda function: function.__name__)
def test_arrays_broadcast_and_stay_untouched(function):
    # Arguments alternate between a column and a row.
    shapes = [(3, 1), (1, 4)]
    arguments = {
        name: between(name, np.linspace(0.2, 0.7, max(shapes[i % 2]))).reshape(
            shapes[i % 2]
        )
        for i, name in enumerate(function.sheet.arguments)
    }
    before = {name: value.copy() for name, value in arguments.items()}
    result = function(**arguments)
    assert all(np.array_equal(arguments[name], before[name]) for name in arguments)
    assert result.shape == np.broadcast_shapes(
        *(value.shape for value in arguments.values())
    )
    last = {name: float(value.flat[-1]) for name, value in arguments.items()}
    assert function(**last) == approx(result.flat[-1], rel=1e-14)


@pytest.mark.parametrize("function", ALL, ids=lambda function: function.__name__)
def test_values_are_finite_without_flow(function):
    still = {"Re": 0.0, "Pe": 0.0, "u": 0.0}
    arguments = point(function, [0.4] * MOST_ARGUMENTS)
    assert np.isfinite(
        function(
            **(arguments | {name: still[name] for name in arguments if name in still})
        )
    )


SINGULAR_AS_PRINTED = [
    (closures.conductivity_zehner_schluender, 1.25 * (0.6 / 0.4) ** (10 / 9)),
    (closures.conductivity_zehner_schluender, 1.0),
    (closures.conductivity_kunii_smith, 1.0),
    (closures.tortuosity_hsu, 1.0),
    (closures.conductivity_hashin_shtrikman_lower, 1.0),
    (closures.conductivity_hashin_shtrikman_upper, 1.0),
]


@pytest.mark.parametrize(("function", "ratio"), SINGULAR_AS_PRINTED)
@pytest.mark.parametrize("offset", [0.0, 1e-12, -1e-7, 1e-3])
def test_slopes_are_right_where_the_printed_formula_is_zero_over_zero(
    function, ratio, offset
):
    arguments = {"k_fluid": 0.5, "k_solid": 0.5 * ratio * (1 + offset), "eps": 0.4}
    for name in arguments:
        expected = difference(function, arguments, name, 1e-5)
        assert slope(function, arguments, name) == approx(expected, rel=1e-7, abs=1e-8)


def test_log_branches_join_with_equal_slopes():
    # The series takes over at |1 - B / kappa| = 0.1.
    B = 1.25 * (0.6 / 0.4) ** (10 / 9)
    zehner = closures.conductivity_zehner_schluender
    for edge in (B / 0.9, B / 1.1):
        arguments = [
            {"k_fluid": 1.0, "k_solid": edge * (1 + offset), "eps": 0.4}
            for offset in (-1e-12, 1e-12)
        ]
        below, above = (slope(zehner, each, "k_solid") for each in arguments)
        assert below == approx(above, rel=1e-10)


def test_slope_of_the_ergun_gradient_at_rest_is_the_viscous_one():
    arguments = {"u": np.zeros(1), "d_p": 2e-3, "eps": 0.4, "mu": 1.8e-5, "rho": 1.2}
    at_rest = slope(closures.pressure_gradient_ergun, arguments, "u")
    assert at_rest == approx(1.8e-5 / closures.permeability_ergun(2e-3, 0.4), rel=1e-13)


def test_every_argument_has_a_standard_name():
    used = {name for function in ALL for name in function.sheet.arguments}
    assert used == set(BOX)
