"""The two algebraic closures among species: where they agree, where they do not, what
they conserve.

Tolerances: 1e-13 of the largest emission, since every result is a sum of a few terms of
    that size; 1e-6 for slopes, a
central difference with a relative step of 1e-5 of terms that may cancel to a hundredth.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from contbed.closures import enclosure
from contbed.closures.optics import SIGMA, optical_coefficients
from contbed.fem.ad.dual import Dual

ROUND_OFF = 1e-13
# char, limestone, inert: of the emulsion half is solid
FRACTIONS = 0.5 * np.array([0.02, 0.18, 0.80])
DIAMETERS = np.array([3e-3, 1e-3, 7e-4])
EMISSIVITIES = np.array([0.85, 0.40, 0.60])
# inert colder than char, limestone colder than both
HOT = np.array([1300.0, 1100.0, 1140.0])
SPECIES = st.tuples(
    st.floats(0.1, 1000.0), st.floats(0.01, 1.0), st.floats(300.0, 2500.0)
)


def mixtures(least, most):
    """Arrays of extinction, emissivity and temperature."""
    return st.lists(SPECIES, min_size=least, max_size=most).map(
        lambda rows: np.array(rows).T
    )


def both(extinction, emissivity, T):
    return (
        enclosure.exchange_equilibrium(extinction * emissivity, T),
        enclosure.exchange_pairwise(extinction, emissivity, T),
    )


def emission(extinction, emissivity, T):
    return np.max(4 * extinction * emissivity * SIGMA * T**4)


def radiosities(extinction, emissivity, T):
    """Net heat of N gray surfaces of areas 4 kappa_m whose view factors are the area
    fractions, by a linear system.
    """
    share = extinction / extinction.sum()
    reflected = (1 - emissivity)[:, None] * share
    J = np.linalg.solve(np.eye(len(T)) - reflected, emissivity * SIGMA * T**4)
    return 4 * extinction * (J - share @ J)


def hot_bed():
    bed = optical_coefficients(FRACTIONS, DIAMETERS, EMISSIVITIES, "independent")
    return bed.absorption + bed.scattering, EMISSIVITIES, HOT


@given(mixtures(1, 6))
def test_what_some_lose_the_others_gain(mixture):
    for lost in both(*mixture):
        assert abs(lost.sum()) <= ROUND_OFF * emission(*mixture)


@given(mixtures(2, 6))
def test_equilibrium_is_the_enclosure_for_any_number_of_species(mixture):
    # The system is singular as all emissivities vanish: at 0.01 its condition number is
    # about 100.
    found, _ = both(*mixture)
    assert found == approx(radiosities(*mixture), rel=0, abs=1e-11 * emission(*mixture))


@given(mixtures(2, 2))
def test_pairs_are_exact_for_two_species(mixture):
    equilibrium, pairs = both(*mixture)
    assert pairs == approx(equilibrium, rel=0, abs=ROUND_OFF * emission(*mixture))


@given(mixtures(3, 6))
def test_pairs_are_exact_for_black_species(mixture):
    extinction, emissivity, T = mixture
    black = np.ones_like(emissivity)
    equilibrium, pairs = both(extinction, black, T)
    assert pairs == approx(
        equilibrium, rel=0, abs=ROUND_OFF * emission(extinction, black, T)
    )


def test_pairs_are_not_exact_for_three_species():
    equilibrium, pairs = both(*hot_bed())
    assert 1.01 < pairs[0] / equilibrium[0] < 1.06


def test_pairs_by_the_printed_equations_with_area_and_volume_of_one_particle():
    extinction, emissivity, T = hot_bed()
    area, volume = np.pi * DIAMETERS**2, np.pi * DIAMETERS**3 / 6
    solids = FRACTIONS / FRACTIONS.sum()
    number = (solids / volume) / (solids / volume).sum()  # eq. 7
    share = number * area / (number * area).sum()  # eq. 6
    area_per_volume = FRACTIONS.sum() * solids * area / volume  # eq. 5 per section
    expected = np.zeros(3)
    for m in range(3):
        for n in range(3):
            if n != m:
                # eq. 3
                inverse = (
                    share[n] * (1 / emissivity[m] - 1)
                    + share[m] * (1 / emissivity[n] - 1)
                    + 1
                )
                # eqs. 2, 10
                expected[m] += (
                    SIGMA
                    * (T[m] ** 4 - T[n] ** 4)
                    * share[n]
                    * area_per_volume[m]
                    / inverse
                )
    found = enclosure.exchange_pairwise(extinction, emissivity, T)
    assert found == approx(
        expected, rel=0, abs=ROUND_OFF * emission(extinction, emissivity, T)
    )


def test_two_black_species_by_hand():
    # G is the mean of both emissions; each loses K (4 sigma T^4 - G) = 2 K sigma (T^4 -
    # T'^4).
    K, T = np.array([50.0, 50.0]), np.array([1200.0, 1000.0])
    expected = 100.0 * SIGMA * (1200.0**4 - 1000.0**4)
    for lost in both(K, np.ones(2), T):
        assert lost == approx([expected, -expected], rel=ROUND_OFF)
    mean = 2 * SIGMA * (1200.0**4 + 1000.0**4)
    assert enclosure.irradiation_equilibrium(K, T) == approx(mean, rel=ROUND_OFF)


def test_the_hottest_loses_and_equal_temperatures_exchange_nothing():
    extinction, emissivity, T = hot_bed()
    for lost in both(extinction, emissivity, T):
        assert lost[T.argmax()] > 0 > lost[T.argmin()]
    for lost in both(extinction, emissivity, np.full(3, 1000.0)):
        assert np.abs(lost).max() <= ROUND_OFF * emission(
            extinction, emissivity, np.full(3, 1000.0)
        )


def test_a_species_that_does_not_absorb_takes_no_part():
    extinction, _, T = hot_bed()
    for lost in both(extinction, np.array([0.85, 0.0, 0.6]), T):
        assert lost[1] == 0.0
        assert lost[0] > 0


def test_a_species_that_vanishes_leaves_the_others_alone():
    extinction, emissivity, T = hot_bed()
    for with_it, without in zip(
        both(extinction * [1, 0, 1], emissivity, T),
        both(extinction[[0, 2]], emissivity[[0, 2]], T[[0, 2]]),
        strict=True,
    ):
        assert with_it[[0, 2]] == approx(without, rel=ROUND_OFF)
        assert with_it[1] == 0.0


def test_positions_are_the_further_axes():
    extinction, emissivity, T = hot_bed()
    factors = np.array([[1.0, 1.1], [1.2, 0.7]])
    for many, one in zip(
        both(
            extinction[:, None, None],
            emissivity[:, None, None],
            T[:, None, None] * factors,
        ),
        both(extinction, emissivity, T * factors[1, 0]),
        strict=True,
    ):
        assert many.shape == (3, 2, 2)
        assert many[:, 1, 0] == approx(one, rel=1e-12)


@pytest.mark.parametrize("which", range(2))
def test_dual_numbers_give_the_slope_to_every_temperature(which):
    extinction, emissivity, _ = hot_bed()
    T = HOT[:, None] * np.array([0.25, 1.0, 1.9])
    step = 1e-5
    duals = [Dual(T[m], {m: 1.0}) for m in range(3)]
    found = both(extinction, emissivity, duals)[which]
    for n in range(3):
        shift = np.zeros_like(T)
        shift[n] = step * T[n]
        high, low = (
            both(extinction[:, None], emissivity[:, None], T + sign * shift)[which]
            for sign in (1, -1)
        )
        expected = (high - low) / (2 * step * T[n])
        for m in range(3):
            assert found[m].tangents[n] == approx(expected[m], rel=1e-6)
