"""Optical coefficients: hand-made numbers, limits, slopes, refused input.

Tolerances: 1e-14 where two ways to the same number differ by round-off only; half a
    unit of the last printed digit
where the reference is a printed number; 1e-8 where a central difference with a relative
step of 1e-5 gives the slope.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from contbed.closures import optics
from contbed.closures import radiation_emissivity_half_space as emissivity_half_space
from contbed.closures.optics import Species, optical_coefficients
from contbed.fem.ad.dual import Dual
from tests.cases import each_case
from tests.refusals import problems_of, refused

ROUND_OFF = 1e-14
# char, limestone, inert of a bubbling bed whose emulsion is half solid
FRACTIONS = 0.5 * np.array([0.02, 0.18, 0.80])
DIAMETERS = np.array([3e-3, 1e-3, 7e-4])
EMISSIVITIES = np.array([0.85, 0.40, 0.60])


def bed(packing="independent", anisotropy=0.0):
    return optical_coefficients(FRACTIONS, DIAMETERS, EMISSIVITIES, packing, anisotropy)


# --- coefficients ---


@given(
    st.lists(
        st.tuples(st.floats(1e-5, 1e-2), st.floats(0.01, 1)), min_size=1, max_size=8
    )
)
def test_extinction_of_classes_is_that_of_their_sauter_mean(classes):
    diameters, weights = np.array(classes).T
    fractions = weights / weights.sum()
    apart = optical_coefficients(
        0.3 * fractions, diameters, np.full(len(fractions), 0.7)
    )
    sauter = 1.0 / (fractions / diameters).sum()
    together = optics.optics([Species("all", 0.3, sauter, 0.7)])
    assert together.extinction == approx(apart.extinction, rel=1e-13)


def test_coefficients_by_hand():
    # kappa = 1.5 * (0.01 / 3e-3, 0.09 / 1e-3, 0.4 / 7e-4) = 5, 135, 6000/7
    here = bed()
    assert here.absorption == approx([4.25, 54.0, 3600 / 7], rel=ROUND_OFF)
    assert here.scattering == approx([0.75, 81.0, 2400 / 7], rel=ROUND_OFF)
    assert here.extinction == approx(6980 / 7, rel=ROUND_OFF)
    assert here.albedo == approx((81.75 + 2400 / 7) * 7 / 6980, rel=ROUND_OFF)


def test_species_list_gives_the_same_as_arrays():
    rows = zip("abc", FRACTIONS, DIAMETERS, EMISSIVITIES, strict=True)
    assert (
        optics.optics([Species(*row) for row in rows], "independent").extinction
        == bed().extinction
    )


def test_close_packing_divides_by_voidage_and_keeps_the_albedo():
    dense, points = bed("close_packed"), bed()
    assert dense.extinction == approx(2 * points.extinction, rel=ROUND_OFF)
    assert dense.albedo == approx(points.albedo, rel=ROUND_OFF)


def test_independent_species_emit_as_much_as_their_surface_and_close_packed_ones_more():
    surface = 6 * FRACTIONS / DIAMETERS
    assert 4 * bed().absorption == approx(EMISSIVITIES * surface, rel=ROUND_OFF)
    assert 4 * bed("close_packed").absorption == approx(
        EMISSIVITIES * surface / 0.5, rel=ROUND_OFF
    )


@pytest.mark.parametrize("share", [1e-3, 1e-6, 0.0])
def test_packings_agree_as_the_particles_vanish(share):
    dense, points = (
        optical_coefficients(share * FRACTIONS, DIAMETERS, EMISSIVITIES, p)
        for p in optics.PACKINGS
    )
    assert np.all(
        np.abs(dense.absorption - points.absorption) <= share * points.absorption
    )
    assert points.absorption == approx(share * bed().absorption, rel=ROUND_OFF)


@pytest.mark.parametrize(("emissivity", "albedo"), [(1.0, 0.0), (0.0, 1.0)])
def test_black_particles_do_not_scatter_and_white_ones_do_not_absorb(
    emissivity, albedo
):
    here = optical_coefficients(FRACTIONS, DIAMETERS, np.full(3, emissivity))
    assert here.albedo == albedo
    assert here.scattering_total == albedo * here.extinction


def test_positions_are_the_further_axes():
    profile = FRACTIONS[:, None] * np.linspace(0.2, 1.0, 5)
    many = optical_coefficients(profile, DIAMETERS, EMISSIVITIES)
    assert many.absorption.shape == (3, 5)
    assert many.transport.shape == (5,)
    last = optical_coefficients(profile[:, -1], DIAMETERS, EMISSIVITIES)
    assert many.diffusion()[-1] == approx(last.diffusion(), rel=ROUND_OFF)


def test_mean_cosine_of_a_diffusely_reflecting_sphere():
    # Phase function 8 / (3 pi) (sin t - t cos t), half its integral against sin t is 1
    # and against sin t cos t is g.
    nodes, weights = np.polynomial.legendre.leggauss(30)
    t, w = 0.5 * np.pi * (nodes + 1), 0.5 * np.pi * weights
    phase = 8 / (3 * np.pi) * (np.sin(t) - t * np.cos(t))
    assert 0.5 * np.sum(w * phase * np.sin(t)) == approx(1.0, rel=ROUND_OFF)
    mean = 0.5 * np.sum(w * phase * np.sin(t) * np.cos(t))
    assert mean == approx(optics.ANISOTROPY_DIFFUSE_SPHERES, rel=ROUND_OFF)


def test_back_scattering_shortens_the_transport_path_of_p1_only():
    here = bed(anisotropy=optics.ANISOTROPY_DIFFUSE_SPHERES)
    K_a, K_s = here.absorption_total, here.scattering_total
    assert here.transport == approx(K_a + 13 / 9 * K_s, rel=ROUND_OFF)
    assert here.diffusion("p1") == approx(1 / (3 * (K_a + 13 / 9 * K_s)), rel=ROUND_OFF)
    assert (
        here.diffusion("two_flux")
        == bed().diffusion("two_flux")
        == 1 / (4 * (K_a + K_s))
    )
    assert bed().diffusion("p1") == approx(1 / (3 * (K_a + K_s)), rel=ROUND_OFF)


# --- thick media and surfaces ---


def test_conductivity_of_p1_is_rosselands_and_of_two_flux_a_quarter_less():
    T, here = 1200.0, bed()
    exact = optics.radiation_rosseland(T, here.transport)
    assert optics.conductivity(T, here.diffusion("p1")) == approx(exact, rel=ROUND_OFF)
    two_flux = optics.conductivity(T, here.diffusion("two_flux"))
    assert two_flux == approx(0.75 * exact, rel=ROUND_OFF)
    assert two_flux == approx(4 * optics.SIGMA * T**3 / here.extinction, rel=ROUND_OFF)


@pytest.mark.parametrize("tau", [1.0, 10.0, 400.0])
@pytest.mark.parametrize(("eps_1", "eps_2"), [(1.0, 1.0), (0.3, 0.8)])
def test_error_of_rosseland_is_that_of_the_closed_form(tau, eps_1, eps_2):
    p1, rosseland = 1 / (0.75 * tau + 1 / eps_1 + 1 / eps_2 - 1), 1 / (0.75 * tau)
    assert optics.error_rosseland(tau, eps_1, eps_2) == approx(
        rosseland / p1 - 1, rel=1e-12
    )


def test_error_of_rosseland_at_optical_thickness_400_is_a_third_of_a_percent():
    assert optics.error_rosseland(400.0) == approx(1 / 300, rel=ROUND_OFF)


def test_emissivity_of_the_bed_as_quoted():
    assert emissivity_half_space(bed().albedo) == approx(0.8622, abs=5e-5)
    assert emissivity_half_space(0.0) == 1.0
    assert emissivity_half_space(1.0) == 0.0


def test_emissivity_of_the_bed_is_the_limit_of_a_thick_two_flux_slab():
    # Emittance of an isothermal slab by two-flux: 2 s / (coth(s tau) + s); at s tau =
    # 20 the coth is 1 to 1e-17.
    s = np.sqrt(1 - 0.5)
    assert emissivity_half_space(0.5) == approx(
        2 * s / (1 / np.tanh(20.0) + s), rel=ROUND_OFF
    )


def test_tube_in_a_bed_as_quoted():
    black = optics.SIGMA * (1150.0**4 - 550.0**4)
    effective = optics.emissivity_immersed(emissivity_half_space(bed().albedo), 0.8)
    assert effective * black == approx(67e3, abs=500)
    assert optics.marshak(0.8) * 4 * black == approx(125e3, abs=500)


def test_black_bed_leaves_the_emissivity_of_the_surface():
    assert optics.emissivity_immersed(1.0, 0.3) == approx(0.3, rel=ROUND_OFF)


@pytest.mark.parametrize("tau", [0.1, 30.0])
def test_marshak_on_two_walls_gives_the_flux_between_gray_plates(tau):
    # Radiative equilibrium: G is linear over tau and q = -(dG/dtau)/3. Unknowns: G at
    # both walls.
    eps_1, eps_2, E_1, E_2 = 0.3, 0.8, 2.0, 0.5
    h_1, h_2 = optics.marshak(eps_1), optics.marshak(eps_2)
    slope = 1 / (3 * tau)
    G_1, G_2 = np.linalg.solve(
        [[slope + h_1, -slope], [-slope, slope + h_2]], [4 * h_1 * E_1, 4 * h_2 * E_2]
    )
    expected = (E_1 - E_2) / (0.75 * tau + 1 / eps_1 + 1 / eps_2 - 1)
    # At tau = 30 the difference of two nearly equal G costs a digit.
    assert slope * (G_1 - G_2) == approx(expected, rel=1e-13)


# --- dual numbers ---


def test_dual_numbers_give_the_slope_to_temperature():
    T, D, step = np.array([300.0, 1200.0, 2500.0]), 3e-4, 1e-5
    found = optics.conductivity(Dual(T, {"T": 1.0}), D).tangents["T"]
    expected = (
        optics.conductivity(T * (1 + step), D) - optics.conductivity(T * (1 - step), D)
    ) / (2 * step * T)
    assert found == approx(expected, rel=1e-8)


def test_dual_numbers_give_the_slope_to_a_volume_fraction():
    def diffusion(first):
        return optical_coefficients(
            [first, 0.2], DIAMETERS[:2], EMISSIVITIES[:2]
        ).diffusion()

    f, step = np.array([0.1, 0.4]), 1e-5
    expected = (diffusion(f * (1 + step)) - diffusion(f * (1 - step))) / (2 * step * f)
    assert diffusion(Dual(f, {"f": 1.0})).tangents["f"] == approx(expected, rel=1e-8)


# --- refused input ---


@each_case(__file__, "bad_input")
def test_bad_input_is_named(make, arguments, message):
    makers = {
        "Species": Species,
        "optics": lambda species: optics.optics([Species(*each) for each in species]),
        "bed": bed,
        "diffusion": lambda level: bed().diffusion(level),
    }
    refused(message, makers[make], *arguments)


def test_all_mistakes_of_a_species_are_told_at_once():
    assert len(problems_of(Species, "char", 2.0, -1e-3, 0.0)) == 3
