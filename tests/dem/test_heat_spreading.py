"""Spreading columns between two spheres: closed forms, Batchelor and O'Brien's law,
a resolved cubic lattice.
"""

import numpy as np
import pytest
import skfem
from pytest import approx
from skfem.helpers import dot, grad

import contbed as cb
from contbed.dem import heat, network
from contbed.dem.heat_spreading import spreading_conductance
from contbed.dem.surface import Surface
from tests.refusals import refused

STEEL = Surface(19e-9, 0.056, 3e9, 2e11, 0.29, 68e-9, accommodation=0.7)


def conductance(distance=2.0, face=3.0, ratio=1e3, **more):
    return float(
        sum(spreading_conductance(1.0, distance, face, (ratio, ratio), 1.0, **more))[0]
    )


def gap_between_perfect_conductors(h, face):
    """Integrate k_f over the gap of unit spheres at distance h, by hand; faces
    within the spheres.
    """
    u = np.sqrt(1.0 - face / np.pi)
    b = 1.0 + 0.5 * h
    return np.pi * (b * np.log((b - u) / (b - 1.0)) - (1.0 - u))


def test_alike_materials_conduct_as_the_material():
    # k face/d for any face, gap, overlap and perfect contact: round-off of a matrix of
    # 96 rings
    face, d = np.meshgrid([1e-3, 0.5, 3.0, 8.0], [1.9, 2.0, 2.1, 3.5])
    for r_contact in (0.0, 0.05):
        fluid, contact = spreading_conductance(
            1.0, d.ravel(), face.ravel(), (0.7, 0.7), 0.7, r_contact
        )
        assert fluid + contact == approx((0.7 * face / d).ravel(), rel=1e-9)


def test_touching_spheres_follow_batchelor_and_o_brien():
    # G = pi R k_f (2 ln(ratio) + K - 3.9), K of the face from perfect conductors that
    # nearly touch
    found = [conductance(ratio=ratio) / np.pi for ratio in (1e4, 1e5, 1e6)]
    # 96 rings over six to eight decades: 1e-3 of G, 3e-3 of a difference
    assert np.diff(found) == approx([2.0 * np.log(10.0)] * 2, rel=4e-3)
    h = 1e-9
    K = gap_between_perfect_conductors(h, 3.0) / np.pi + np.log(h)
    # printed with two digits
    assert found[1] - 2.0 * np.log(1e5) - K == approx(-3.9, abs=0.03)


@pytest.mark.parametrize("h", [1e-4, 1e-2, 0.3])
def test_a_wide_gap_is_that_of_perfect_conductors(h):
    # ratio^2 h/R >> 1, and the particles themselves 1e-4 of it
    assert conductance(2.0 + h, ratio=1e6) == approx(
        gap_between_perfect_conductors(h, 3.0), rel=1e-3
    )
    # a jump of the temperature is a gap of that width
    assert conductance(ratio=1e6, jump=h) == approx(
        gap_between_perfect_conductors(h, 3.0), rel=1e-3
    )


@pytest.mark.parametrize("r_contact", [0.01, 0.1, 0.3])
def test_a_contact_without_fluid_is_a_constriction(r_contact):
    # tube of the face: Negus and Yovanovich's series for an isothermal spot (1984), and
    # the length of the tube; the edge of the spot lies within a ring of 15 % of its
    # radius, +-6 %
    r_face = (3.0 / np.pi) ** 0.5
    e = r_contact / r_face
    spot = (1.0 - 1.40978 * e + 0.34406 * e**3 + 0.0435 * e**5) / (4.0 * r_contact)
    exact = 1.0 / (2.0 * spot + 2.0 / 3.0)
    _, contact = spreading_conductance(1.0, 2.0, 3.0, (1.0, 1.0), 1e-5, r_contact)
    assert float(contact[0]) == approx(exact, rel=0.06)


def test_a_weak_joint_is_all_the_resistance():
    _, contact = spreading_conductance(
        1.0, 2.0, 3.0, (1e3, 1e3), 1e-9, 0.05, joint=1e-3
    )
    assert float(contact[0]) == approx(1e-3 * np.pi * 0.05**2, rel=1e-4)


def test_what_conducts_better_adds():
    series = [
        conductance(**change)
        for change in ({"jump": 1e-3}, {"jump": 1e-4}, {}, {"r_contact": 1e-2})
    ]
    assert (np.diff(series) > 0).all()
    one, other = (
        sum(spreading_conductance(1.0, 2.01, 3.0, k, 1.0))
        for k in ((10.0, 50.0), (50.0, 10.0))
    )
    assert one == approx(other, rel=1e-14)
    with pytest.raises(ValueError, match="no better"):
        spreading_conductance(1.0, 2.0, 3.0, (1.0, 1.0), 1.1)


def test_many_pairs_at_once_are_single_ones():
    d, face = np.linspace(1.99, 2.6, 300), np.linspace(0.2, 4.0, 300)
    together = spreading_conductance(
        1.0, d, face, (50.0, 50.0), 1.0, np.where(d < 2.0, 0.01, 0.0)
    )
    for n in (0, 255, 256, 299):
        alone = spreading_conductance(
            1.0, d[n], face[n], (50.0, 50.0), 1.0, 0.01 if d[n] < 2.0 else 0.0
        )
        assert [together.fluid[n], together.contact[n]] == approx(
            [alone.fluid[0], alone.contact[0]], rel=1e-10
        )


def resolved_simple_cubic(ratio, cells):
    """Conductivity of touching unit spheres in a simple cubic lattice, k_fluid = 1:
    finite elements on 1/16 of a cell.

    Spherical coordinates about the centre of a sphere: s along the radius, 1 at the
    surface, then to the side of the box; angles from the contact, both graded towards
    it; isothermal planes through the centre and the contact.
    """
    solid, gas, near, far, turn = cells
    s = np.concatenate(
        [
            1.0 - np.geomspace(0.999, 1e-6, solid),
            [1.0],
            1.0 + np.arange(1, gas + 1) / gas,
        ]
    )
    t = np.concatenate(
        [np.geomspace(1e-6, 1.0, near + 1), 1.0 + np.arange(1, far + 1) / far]
    )
    S, T, phi = np.meshgrid(
        s, t, np.linspace(0.0, np.pi / 4.0, turn + 1), indexing="ij"
    )
    edge = np.arctan(1.0 / np.cos(phi))
    theta = np.where(T <= 1.0, edge * T, edge + (np.pi / 2.0 - edge) * (T - 1.0))
    box = np.where(
        T <= 1.0,
        1.0 / np.cos(np.minimum(theta, 1.5)),
        1.0 / (np.sin(theta) * np.cos(phi)),
    )
    radius = np.where(S <= 1.0, S, 1.0 + (S - 1.0) * (box - 1.0))
    x = [
        radius * np.sin(theta) * np.cos(phi),
        radius * np.sin(theta) * np.sin(phi),
        radius * np.cos(theta),
    ]
    node = np.arange(S.size).reshape(S.shape)
    n = [size - 1 for size in S.shape]
    corners = (
        (0, 0, 0),
        (0, 0, 1),
        (0, 1, 0),
        (1, 0, 0),
        (0, 1, 1),
        (1, 0, 1),
        (1, 1, 0),
        (1, 1, 1),
    )
    hexes = np.stack(
        [node[a : a + n[0], b : b + n[1], c : c + n[2]].ravel() for a, b, c in corners]
    )
    basis = skfem.Basis(
        skfem.MeshHex(np.stack([a.ravel() for a in x]), hexes),
        skfem.ElementHex1(),
        intorder=3,
    )
    inside = np.repeat(np.arange(n[0]) < solid, n[1] * n[2])

    @skfem.BilinearForm
    def form(u, v, w):
        return w["k"] * dot(grad(u), grad(v))

    k = np.where(inside, ratio, 1.0)[:, None] * np.ones_like(basis.dx)
    K = form.assemble(basis, k=k)
    hot, cold = node[-1, t <= 1.0 + 1e-12].ravel(), node[:, -1].ravel()
    T_nodes = np.zeros(S.size)
    T_nodes[hot] = 1.0
    T_nodes = skfem.solve(*skfem.condense(K, x=T_nodes, D=np.union1d(hot, cold)))
    return 2.0 * float(T_nodes @ (K @ T_nodes))


@pytest.mark.parametrize(
    ("ratio", "off"), [(1.0, 1e-6), (10.0, 0.06), (100.0, 0.02), (1555.0, 0.03)]
)
def test_a_resolved_simple_cubic_lattice(ratio, off):
    # a disc stands for a square face and a sheet for the gap: +5, -1 and -2 %; the mesh
    # itself is within 1 %
    x, box = np.zeros((1, 3)), (np.zeros(3), np.full(3, 2.0))
    pairs = heat.voronoi_pairs(x, box, (True, True, True))
    parts = heat.conductances(
        pairs, 1.0, heat.Conduction(ratio, 1.0, paths="spreading")
    )
    cell = network.periodic_cell(1, pairs, parts, 8.0)
    assert cell.mean == approx(
        resolved_simple_cubic(ratio, (32, 7, 32, 12, 5)), rel=off
    )


def test_a_homogeneous_cell_is_exact():
    x, box = np.random.default_rng(3).random((50, 3)), (np.zeros(3), np.ones(3))
    pairs = heat.voronoi_pairs(x, box, (True, True, True))
    parts = heat.conductances(pairs, 0.12, heat.Conduction(0.3, 0.3, paths="spreading"))
    cell = network.periodic_cell(len(x), pairs, parts, 1.0)
    assert cell.conductivity == approx(0.3 * np.eye(3), abs=1e-9)


def test_a_rough_surface_in_a_gas():
    # steel of 6.4 mm, contact of 8 um: Hertz's mean pressure from the force, 4/3 E*
    # r^3/R*
    R, r = 3.2e-3, 8e-6
    E = 2e11 / 2 / (1 - 0.29**2)
    pressure = 4.0 / 3.0 * E * r**3 / (0.5 * R) / (np.pi * r**2)
    joint, jump = STEEL.resistances(np.array([r, 0.0]), R, 42.0, 0.027)
    assert jump == approx(415.02e-9, rel=1e-4)
    asperities = 1.25 * 42.0 * 0.056 / 19e-9 * (pressure / 3e9) ** 0.95
    gas = 0.027 / (1.53 * 2**0.5 * 19e-9 * (pressure / 3e9) ** -0.097 + jump)
    assert joint[0] == approx(asperities + gas, rel=1e-12)
    assert np.isfinite(joint[1])


def test_a_scene_with_spreading_paths(tmp_path):
    text = """
[particles]
lattice = { type = "sc", contact_radius = "8 um" }
paths = "spreading"
[gas]
conductivity = 0.027
mean_free_path = "68 nm"
accommodation = 0.7
[solids.steel]
diameter = "6.4 mm"
conductivity = 42.0
roughness = "19 nm"
asperity_slope = 0.056
microhardness = "3 GPa"
youngs_modulus = "200 GPa"
poisson_ratio = 0.29
"""
    path = tmp_path / "scene.toml"
    path.write_text(text)
    result = cb.run(cb.load(path))
    found, R = result.qoi, 3.2e-3
    # Hertz's mean pressure over the hardness, in the declared range of one law only
    E = 2e11 / 2 / (1 - 0.29**2)
    share = 4.0 / 3.0 * E * 8e-6 / (np.pi * R / 2) / 3e9
    asperities, separation, jumps = (use["ranges"] for use in result.closures)
    for use, outside in ((asperities, 0.0), (separation, 1.0)):
        assert use["pressure/hardness"]["used"] == approx([share, share], rel=1e-12)
        assert use["pressure/hardness"]["share_outside"] == outside
    assert jumps["accommodation"]["used"] == [0.7, 0.7]
    assert not result.warnings
    path.write_text(text.replace("3 GPa", "200 MPa"))
    soft = cb.run(cb.load(path))
    assert soft.closures[0]["share_outside"] == 1.0
    assert [text.split(",")[0] for text in soft.warnings] == [
        "contacts bear a mean pressure of up to 2.32e+08 Pa"
    ]
    joint, jump = STEEL.resistances(np.array([8e-6]), R, 42.0, 0.027)
    G = spreading_conductance(
        R, 2 * R, 4 * R**2, (42.0, 42.0), 0.027, 8e-6, joint, jump
    )
    # the distance carries the rounding of the lattice
    assert found["k_eff [W/m/K]"] == approx(float(sum(G)[0]) / (2 * R), rel=1e-6)
    path.write_text(text + "emissivity = 0.5\n[radiation]\ntemperature = 1000.0\n")
    # six neighbours, each with its share of the solid
    radiation = (
        4.0
        * heat.STEFAN_BOLTZMANN
        * 0.5
        * 1e9
        * np.pi
        * (2 * R) ** 2
        * (np.pi / 6.0)
        / 6.0
    )
    more = cb.run(cb.load(path)).qoi["k_eff [W/m/K]"] - found["k_eff [W/m/K]"]
    assert more == approx(radiation / (2 * R), rel=1e-6)
    smooth = text.replace("spreading", "cones")
    path.write_text(smooth)
    refused('paths = "spreading" alone', cb.load, path)
    path.write_text(text.replace("conductivity = 42.0", "conductivity = 0.01"))
    refused("conduct better than the gas", cb.load, path)
