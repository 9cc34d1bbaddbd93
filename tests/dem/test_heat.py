"""Heat between two particles and in an assembly, against integrals in high
precision, limits and sums.
"""

import itertools

import mpmath as mp
import numpy as np
import pytest
from pytest import approx
from scipy.special import gamma

import contbed as cb
from contbed.dem import heat, heat_impact, heat_pair
from contbed.loading import loads

CUBE = ([0.0] * 3, [1.0] * 3)
CLOSED = (True, True, True)


def two_spheres(R_i, R_j, half_gap, k_i, k_j, k_fluid, eps, r_contact):
    """Eq. 5 in 30 digits, for R_i <= R_j; r = r_c + (r_sf - r_c) s^3 takes the
    narrow gap apart.
    """
    with mp.workdps(30):
        R_i, R_j, H, k_i, k_j, k_fluid, eps, r_contact = map(
            mp.mpf, (R_i, R_j, half_gap, k_i, k_j, k_fluid, eps, r_contact)
        )
        d = R_i + R_j + 2 * H
        D_i = (d**2 + R_i**2 - R_j**2) / (2 * d)
        D_j = d - D_i
        cone = mp.mpf(heat_pair.CONE) * R_i * mp.cbrt(1 / (1 - eps))
        end = R_i * cone / mp.sqrt(cone**2 + D_i**2)
        cone_j = D_j * end / mp.sqrt(R_j**2 - end**2)

        def integrand(s):
            r = r_contact + (end - r_contact) * s**3
            u_i, u_j = mp.sqrt(R_i**2 - r**2), mp.sqrt(R_j**2 - r**2)
            path = (
                (u_i - r * D_i / cone) / k_i
                + (u_j - r * D_j / cone_j) / k_j
                + (d - u_i - u_j) / k_fluid
            )
            return 2 * mp.pi * r * 3 * s**2 * (end - r_contact) / path

        return float(mp.quad(integrand, [0, 0.05, 0.2, 0.6, 1]))


RATIOS = (0.01, 0.5, 1.0, 1.6, 1.634, 1.7, 2.0, 30.0, 1e3, 1e4, 1e6)


@pytest.mark.parametrize("eps", [0.26, 0.4, 0.55])
@pytest.mark.parametrize("half_gap", [0.0, 2.0**-20, 2.0**-7, 0.125, 0.5])
def test_the_closed_form_is_the_integral(eps, half_gap):
    # 1e-12 is asked for; gaps are binary fractions, so that no digit is lost in the
    # distance already
    ratios = RATIOS if eps == 0.4 else RATIOS[::3]
    for ratio, r_contact in itertools.product(
        ratios, (0.0, 1e-3, 0.05) if half_gap == 0 else (0.0,)
    ):
        found = heat_pair.gap_conductance(
            1.0, 1.0, 2.0 + 2.0 * half_gap, ratio, ratio, 1.0, eps, r_contact
        )
        exact = two_spheres(1, 1, half_gap, ratio, ratio, 1, eps, r_contact)
        assert float(found) == approx(exact, rel=1e-12), (ratio, r_contact)


@pytest.mark.parametrize("R", [1.0, 1.25, 3.0])
def test_unlike_particles_by_quadrature(R):
    # the integrand is steepest at the contact where particles conduct well, and at the
    # rim where they conduct badly
    for half_gap, k in itertools.product(
        (0.0, 2.0**-10, 0.25), ((5.0, 50.0), (1e4, 1e4), (0.01, 0.01))
    ):
        args = (*k, 1.0, 0.4)
        found = heat_pair.gap_conductance(1.0, R, 1.0 + R + 2 * half_gap, *args)
        assert float(found) == approx(two_spheres(1, R, half_gap, *args, 0), rel=1e-12)
        swapped = heat_pair.gap_conductance(
            R, 1.0, 1.0 + R + 2 * half_gap, *k[::-1], 1.0, 0.4
        )
        assert float(swapped) == approx(float(found), rel=1e-15)


def test_published_values_and_the_end_of_reach():
    value = (
        heat_pair.gap_conductance(
            1.0, 1.0, [2.0, 2.02, 3.0, 3.0000001], 100.0, 100.0, 1.0, 0.4
        )
        / np.pi
    )
    assert value[:3] == approx(
        [3.00020696363, 2.25653118815, 0.150378444168], rel=1e-11
    )
    assert value[3] == 0.0


def test_overlapping_particles_count_as_touching():
    G = heat_pair.gap_conductance(1.0, 1.0, [1.99, 2.0], 10.0, 10.0, 1.0, 0.4, 0.02)
    assert G[0] == G[1]


def test_columns_are_exact_between_alike_materials():
    # k face/d for any face, gap and overlap: round-off
    face, d = np.meshgrid([1e-3, 0.5, 3.0, 8.0], [1.9, 2.0, 2.1, 3.5])
    G = heat_pair.column_conductance(1.0, d, face, 0.7, 0.7, 0.7)
    assert approx(0.7 * face / d, rel=1e-14) == G
    assert heat_pair.contact_excess(0.1, 0.7, 0.7, 0.7) == approx(0.0, abs=1e-16)


@pytest.mark.parametrize("ratio", [0.01, 0.9999, 1.001, 1.02, 5.0, 1e4])
@pytest.mark.parametrize("distance", [2.0, 2.25])
def test_columns_are_their_integral(ratio, distance):
    face = 2.0
    rim = min(1.0, (face / np.pi) ** 0.5)

    def integrand(angle):
        u = mp.cos(angle)
        gap = distance - 2 * u
        return 2 * mp.pi * mp.sin(angle) * u / ((distance - gap) / mp.mpf(ratio) + gap)

    exact = float(mp.quad(integrand, [0, 0.01, 0.1, mp.asin(rim)]))
    found = heat_pair.column_conductance(1.0, distance, face, ratio, ratio, 1.0)
    # near 1 both the logarithm and its series run through 10 terms of (1e-2)^n
    assert float(found) == approx(exact, rel=1e-12)


def test_contact_and_its_correction():
    # as the paper prints
    assert heat_pair.correction(1e7, 5e10, heat_pair.IMPACT) == approx(0.182, abs=5e-4)
    assert heat_pair.correction(1e7, 5e10) == approx(0.0585, abs=5e-5)
    r = heat_pair.contact_radius(1e-3, 1e-3, [1.99e-3, 2e-3, 2.1e-3], factor=0.5)
    assert r == approx([0.5 * (0.5e-3 * 1e-5) ** 0.5, 0.0, 0.0], rel=1e-12)
    # Batchelor and O'Brien
    assert heat_pair.contact_conductance(1e-5, 3.0, 3.0) == approx(2 * 3.0 * 1e-5)


def test_one_impact():
    # values of a direct integration of Hertz's law for glass of 2 mm at 0.1 m/s
    mass = 2500 * 4 / 3 * np.pi * 1e-9
    impact = heat_impact.hertz_impact(0.5e-3, mass / 2, 1e7 / (2 * 0.91), 0.1)
    assert impact.overlap / 2e-3 == approx(5.49e-3, rel=1e-3)
    assert impact.duration == approx(3.232e-4, rel=1e-3)
    exact = 2 * np.sqrt(np.pi) * gamma(1.4) / gamma(0.9)
    assert impact.duration * 0.1 / impact.overlap == approx(exact, rel=1e-12)
    capacity = 2500 * 840.0
    G = heat_impact.impact_conductance(impact, (0.84, 0.84), (capacity, capacity))
    assert G * impact.duration == approx(1.865e-7, rel=1e-3)
    c = heat_pair.correction(1e7, 5e10, heat_pair.IMPACT)
    stiff = heat_impact.hertz_impact(0.5e-3, mass / 2, 5e10 / (2 * 0.91), 0.1)
    real = (
        heat_impact.impact_conductance(stiff, (0.84, 0.84), (capacity, capacity))
        * stiff.duration
    )
    soft = (
        heat_impact.impact_conductance(impact, (0.84, 0.84), (capacity, capacity), c)
        * impact.duration
    )
    # the correction of an impact is exact: c^3
    assert soft == approx(real, rel=1e-12)
    one, other = (
        heat_impact.impact_conductance(impact, k, h)
        for k, h in (((1.0, 9.0), (1e6, 3e6)), ((9.0, 1.0), (3e6, 1e6)))
    )
    assert one == other


def test_the_factor_of_an_impact():
    found = heat_impact.impact_factor(np.array([0.0, 0.1, 0.5, 1.0, 5.0, 10.0]), 1.0)
    assert found == approx([0.9011, 0.9215, 0.9984, 1.0859, 1.610, 2.076], abs=6e-4)
    # C1 changes its sign here
    through = heat_impact.impact_factor(0.1, np.linspace(0.55, 0.56, 101))
    assert np.abs(np.diff(through, 2)).max() < 1e-6


def test_pairs_through_periodic_sides():
    rng = np.random.default_rng(5)
    x = rng.random((40, 3))
    pairs = heat.near_pairs(x, 0.3, CUBE, CLOSED)
    offset = x[None] - x[:, None]
    offset -= np.round(offset)
    wanted = {
        (i, j)
        for i, j in itertools.combinations(range(40), 2)
        if np.linalg.norm(offset[i, j]) <= 0.3
    }
    assert {
        tuple(sorted(pair))
        for pair in zip(pairs.i.tolist(), pairs.j.tolist(), strict=True)
    } == wanted
    assert len(pairs.i) == len(wanted)
    # a particle and its own images, each pair once
    one = heat.near_pairs(np.zeros((1, 3)), 1.0, CUBE, CLOSED)
    assert len(one.i) == 3
    assert np.abs(one.vector).sum(0) == approx([1.0, 1.0, 1.0])


@pytest.mark.parametrize(
    "periodic", [CLOSED, (False, False, False), (True, False, True)]
)
def test_voronoi_cells_fill_the_box(periodic):
    x = np.random.default_rng(2).random((500, 3))
    pairs = heat.voronoi_pairs(x, CUBE, periodic)
    if periodic == CLOSED:
        # sum of A d n n over the pairs is the volume along each axis: what makes a
        # homogeneous bed exact
        moment = np.einsum(
            "p,pa,pb->ab", pairs.face / pairs.distance, pairs.vector, pairs.vector
        )
        assert moment == approx(np.eye(3), abs=1e-13)
    # Gauss: the faces of a cell away from the walls close
    normal = pairs.face[:, None] * pairs.vector / pairs.distance[:, None]
    sums = np.zeros((500, 3))
    np.add.at(sums, pairs.i, normal)
    np.add.at(sums, pairs.j, -normal)
    inner = (
        np.all((x > 0.4) & (x < 0.6), axis=1)
        if periodic != CLOSED
        else np.ones(500, dtype=bool)
    )
    assert inner.any()
    assert np.abs(sums[inner]).max() < 1e-13


def test_radiation_between_pairs_is_that_of_eqs_8_and_9_on_a_lattice():
    """4 sigma e A T^3 (T_seen - T) of one particle, T_seen = eps T + (1 - eps) mean of
    its neighbours: every particle of a lattice has as many as the next, and T varies by
    1e-6 of itself.
    """
    side = np.arange(4.0)
    x = np.stack(np.meshgrid(side, side, side), -1).reshape(-1, 3)
    box = (np.zeros(3), np.full(3, 4.0))
    T = 1000.0 + 1e-3 * np.random.default_rng(4).random(64)
    pairs = heat.near_pairs(x, 1.5, box, CLOSED)
    both = np.concatenate([pairs.i, pairs.j]), np.concatenate([pairs.j, pairs.i])
    mean = np.bincount(both[0], T[both[1]], 64) / np.bincount(both[0], minlength=64)
    slope = 4.0 * 5.670374419e-8 * 0.7 * np.pi * 1000.0**3
    wanted = slope * (1.0 - 0.4) * (mean - T)
    G = heat.radiation_conductance(pairs, 64, 1000.0, 1.0, 0.7, 0.4)
    flow = G * (T[pairs.j] - T[pairs.i])
    found = np.bincount(pairs.i, flow, 64) - np.bincount(pairs.j, flow, 64)
    assert found == approx(wanted, abs=5e-6 * np.abs(wanted).max())


def test_convection():
    assert heat.convection(56.2, 0.71, 0.026, 2e-3) * 2e-3 / 0.026 == approx(
        10.03, abs=0.01
    )


def test_mechanisms_add_up_and_need_their_faces():
    x = np.random.default_rng(1).random((30, 3))
    pairs = heat.near_pairs(x, 0.3)
    full = heat.conductances(pairs, 0.1, heat.Conduction(10.0, 1.0))
    assert set(full) == {"contact", "fluid_touching", "fluid_apart"}
    assert not (full["fluid_touching"] * full["fluid_apart"]).any()
    assert heat.total(full) == approx(sum(full.values()), rel=1e-15)
    assert set(heat.conductances(pairs, 0.1, heat.Conduction(10.0, None))) == {
        "contact"
    }
    with pytest.raises(ValueError, match="Voronoi faces"):
        heat.conductances(pairs, 0.1, heat.Conduction(10.0, 1.0, paths="columns"))


VACUUM = """
particles.lattice = { type = "sc", contact_radius = "20 um" }
solids.balls = { diameter = "10 mm", conductivity = 20, emissivity = 0.8 }
"""


def test_neighbours_are_all_that_is_seen_in_a_vacuum():
    """Each pair conducts 4 sigma T^3 e pi d^2 over the number of neighbours that a ball
    sees within 1.5 d. Of a simple cubic lattice these are 6 at d and 12 at sqrt(2) d, of
    which 1 + 4 pairs of each ball cross a plane: k_r = 5/18 pi e 4 sigma T^3 d.
    """
    k = [
        cb.run(loads(VACUUM + more)).qoi["k_eff [W/m/K]"]
        for more in ("", 'radiation = { temperature = "800 K" }')
    ]
    per_factor = 4.0 * heat.STEFAN_BOLTZMANN * 800.0**3 * 0.01
    assert k[1] - k[0] == approx(per_factor * 0.8 * np.pi * 5.0 / 18.0, rel=1e-6)
