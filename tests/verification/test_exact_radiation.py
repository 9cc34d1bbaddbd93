"""Radiation references against tables, each other, limits and identities.

Tables carry as many digits as they agree between two independent methods; a tolerance
of half a unit of the last digit then holds, `UNIT` below. Identities hold to the stated
accuracy of the solvers, about 1e-12.
"""

import re

import numpy as np
import pytest
from pytest import approx
from scipy.special import expn

from contbed.loading import from_dict
from studies._exact.conduction_radiation import (
    conduction_diffusion,
    conduction_radiation,
)
from studies._exact.radiation import (
    P1,
    TWO_FLUX,
    equilibrium_flux,
    gray_plates,
    isothermal_slab,
    square_p1,
    square_transport,
)
from studies._exact.transport import (
    Equilibrium,
    half_space_emittance,
    slab,
    slab_emittance,
)
from tests.scene_text import scene_of

UNIT = 0.51

# optical thickness: Psi, slip 1 - Phi(0), error of two-flux and of P1 in percent; black
# plates in radiative equilibrium
HEASLET_WARMING = {
    0.01: (0.99027458292, 0.48738707724, -0.02, 0.23),
    0.1: (0.91570287383, 0.42898896903, -0.72, 1.59),
    1.0: (0.55340599333, 0.24185354150, -9.65, 3.26),
    10.0: (0.11674511351, 0.05055212200, -22.13, 0.77),
    100.0: (0.01314653524, 0.00569261675, -24.69, 0.09),
}

# albedo, optical thickness: emittance of an isothermal slab, error of two-flux and of
# P1 in percent
EMITTANCE = {
    (0.0, 0.5): (0.55679127145, 13.5, 15.0),
    (0.5, 1.0): (0.55912600976, 7.65, 10.3),
    (0.9, 10.0): (0.51812871522, -7.5, None),
    (0.99, 100.0): (0.20543633532, -11.5, 0.78),
}

# tau: q/(sigma T1^4) at N = 0.01, 0.1, 1, 10, then two-flux and P1 at N = 0.01; theta_L
# = 0.5, black, no scattering
CONDUCTION = {
    0.1: ((1.07986746, 2.87994301, 20.87994285, 200.87994275), 1.07676840, 1.09777374),
    1.0: ((0.56749324, 0.76938052, 2.57243599, 20.57233885), 0.51877841, 0.59479876),
    10.0: ((0.11309444, 0.13346805, 0.31495919, 2.11461563), 0.08845331, 0.11431007),
}

# kappa L: q/(sigma T^4) at x/L = 0.1, 0.3, 0.5 on the wall of a square: transport, P1
SQUARE = {
    0.1: ((0.08438505, 0.09902948, 0.10304383), None),
    1.0: (
        (0.51249157, 0.61114783, 0.63593527),
        (0.5695323283, 0.6483492966, 0.6727074122),
    ),
    10.0: ((0.94241626, 0.99665757, 0.99945553), (1.00776875, 1.07023921, 1.07171394)),
}


@pytest.mark.parametrize("tau", HEASLET_WARMING)
def test_black_plates(tau):
    psi, slip, two_flux, p1 = HEASLET_WARMING[tau]
    exact = Equilibrium(tau)
    assert abs(exact.flux - psi) < UNIT * 1e-11
    assert abs(exact.slip - slip) < UNIT * 1e-11
    assert 100.0 * (equilibrium_flux(tau, TWO_FLUX) / psi - 1.0) == approx(
        two_flux, abs=0.0051
    )
    assert 100.0 * (equilibrium_flux(tau, P1) / psi - 1.0) == approx(p1, abs=0.0051)


@pytest.mark.parametrize("tau", [tau for tau in HEASLET_WARMING if tau >= 3.0])
def test_a_scene_says_how_low_two_flux_is(tau):
    """By the exact flux between black plates, within 1 % of it."""
    text = f"""
        [mesh]
        type = "line"
        length = 1.0

        [radiation]
        scattering = {tau!r}
        level = "two_flux"

        [boundary]
        left.radiation = {{ temperature = 1000.0, emissivity = 1.0 }}
        right.radiation = {{ temperature = 300.0, emissivity = 1.0 }}
    """
    scene = from_dict(scene_of(text))
    (said,) = (text for text in scene.warnings if "two-flux method carries" in text)
    low = float(re.search(r"carries ([\d.]+) %", said)[1])
    exact = HEASLET_WARMING[tau][0]
    assert low / 100.0 == approx(
        1.0 - equilibrium_flux(tau, TWO_FLUX) / exact, abs=0.01
    )
    assert "p1 or rosseland" in said
    absorbing = {"radiation.temperature": 500.0, "radiation.absorption": tau}
    warm = scene_of(text, absorbing)
    assert not any(
        "two-flux method carries" in text for text in from_dict(warm).warnings
    )


def test_equilibrium_limits():
    thin, thick = 1e-4, 100.0
    # the next term is tau^2 ln(tau)/2
    assert Equilibrium(thin).flux == approx(1.0 - thin, abs=1e-7)
    # Hopf's constant: the profile extrapolates to the wall powers at 0.710446 mean free
    # paths behind the walls
    assert Equilibrium(thick).flux == approx(
        4.0 / 3.0 / (thick + 2.0 * 0.7104460896), abs=1e-12
    )


@pytest.mark.parametrize("emissivity", [(0.3, 0.8), (1.0, 0.01), (1e-6, 1e-3)])
@pytest.mark.parametrize("D", [None, TWO_FLUX, P1])
def test_gray_plates_follow_from_black_ones(D, emissivity):
    tau = 1.0
    solve = (
        (lambda e: Equilibrium(tau, e).flux)
        if D is None
        else (lambda e: equilibrium_flux(tau, D, e))
    )
    black, gray = solve((1.0, 1.0)), solve(emissivity)
    # the walls' own balance has lost 1/e of the 16 digits
    assert gray == approx(gray_plates(black, emissivity), rel=1e-14 / min(emissivity))


@pytest.mark.parametrize("case", EMITTANCE)
def test_isothermal_slab(case):
    albedo, tau = case
    exact, two_flux, p1 = EMITTANCE[case]
    assert abs(slab_emittance(tau, albedo) - exact) < UNIT * 1e-11
    for D, percent in ((TWO_FLUX, two_flux), (P1, p1)):
        if percent is not None:
            error = 100.0 * (isothermal_slab(tau, D, albedo) / exact - 1.0)
            assert error == approx(percent, abs=0.06)


def test_slab_without_scattering():
    for tau in (1e-3, 0.5, 20.0):
        assert slab_emittance(tau, 0.0) == approx(1.0 - 2.0 * expn(3, tau), abs=1e-13)


def test_kirchhoff():
    """What an isothermal slab emits, it absorbs of black diffuse walls:
    1 - reflected - transmitted.
    """
    tau, albedo = 0.7, 0.6
    medium = slab(tau)
    powers = np.zeros(len(medium.depth) + 2)
    powers[-2] = 1.0
    entering, leaving = medium.respond(albedo).wall_fluxes(powers)
    assert entering - leaving == approx(slab_emittance(tau, albedo), abs=1e-13)


def test_half_space():
    s = 0.8622 / (2.0 - 0.8622)
    albedo = np.array([0.0, 1.0 - s * s, 0.9])
    exact = half_space_emittance(albedo)
    assert exact[0] == approx(1.0, abs=1e-14)
    assert exact[1] == approx(0.8832, abs=UNIT * 1e-4)
    assert exact[2] == approx(slab_emittance(60.0, 0.9), abs=1e-12)
    # the leading term at high albedo
    near = 1.0 - 1e-8
    assert half_space_emittance(near) == approx(4.0 / np.sqrt(3.0) * 1e-4, rel=3e-4)
    with pytest.raises(ValueError, match="albedo"):
        half_space_emittance(1.0)


@pytest.mark.parametrize("tau", CONDUCTION)
def test_conduction_and_radiation(tau):
    exact, two_flux, p1 = CONDUCTION[tau]
    for N, total in zip((0.01, 0.1, 1.0, 10.0), exact, strict=True):
        assert abs(conduction_radiation(tau, N, 0.5).total - total) < UNIT * 1e-8
    assert (
        abs(conduction_diffusion(tau, 0.01, 0.5, TWO_FLUX).total - two_flux)
        < UNIT * 1e-8
    )
    assert abs(conduction_diffusion(tau, 0.01, 0.5, P1).total - p1) < UNIT * 1e-8


@pytest.mark.parametrize("albedo", [0.0, 0.7, 1.0])
def test_conduction_without_coupling(albedo):
    """At albedo 1, and for N -> infinity, conduction and radiation add."""
    tau, e, cold = 1.5, (0.5, 0.9), 0.4
    N = 1e6 if albedo < 1.0 else 0.02
    for solve, psi in (
        (
            lambda: conduction_diffusion(tau, N, cold, P1, albedo, e),
            equilibrium_flux(tau, P1, e),
        ),
        (
            lambda: conduction_radiation(tau, N, cold, albedo, e),
            Equilibrium(tau, e).flux,
        ),
    ):
        result = solve()
        conducted = 4.0 * N * (1.0 - cold) / tau
        straight = 1.0 - (1.0 - cold) * result.depth / tau
        assert result.theta == approx(straight, abs=1e-6 if albedo < 1.0 else 1e-13)
        if albedo == 1.0:
            assert result.total == approx(conducted + psi * (1.0 - cold**4), rel=1e-12)
            assert result.radiative == approx([psi * (1.0 - cold**4)] * 2, rel=1e-11)


def test_conduction_with_gray_walls_and_scattering():
    """Exchanging the walls turns the flux round; the degree of the collocation no
    longer matters.
    """
    tau, N, cold, albedo = 2.0, 0.02, 0.3, 0.6
    forward = conduction_radiation(tau, N, cold, albedo, (0.3, 0.8))
    backward = conduction_radiation(tau, N / cold**3, 1.0 / cold, albedo, (0.8, 0.3))
    assert backward.total * cold**4 == approx(-forward.total, rel=1e-11)
    coarse, fine = (
        conduction_diffusion(tau, N, cold, P1, albedo, (0.3, 0.8), degree)
        for degree in (0, 140)
    )
    assert coarse.total == approx(fine.total, rel=1e-11)
    assert coarse.radiative == approx(fine.radiative, rel=1e-10)


@pytest.mark.parametrize("tau", SQUARE)
def test_square(tau):
    exact, p1 = SQUARE[tau]
    x = np.array([0.1, 0.3, 0.5])
    assert square_transport(x, tau) == approx(exact, abs=UNIT * 1e-8)
    assert square_p1(x, tau) == approx(square_p1(1.0 - x, tau), abs=1e-10)
    if p1 is not None:
        digits = 1e-10 if tau == 1.0 else 1e-8
        assert square_p1(x, tau) == approx(p1, abs=UNIT * digits)
        assert square_p1(x, tau, degree=110) == approx(square_p1(x, tau), abs=1e-10)
