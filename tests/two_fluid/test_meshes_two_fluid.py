"""The two-fluid model on unstructured meshes of every shape of cell: exact states
stay, mass is kept, scenes run.
"""

import meshio
import numpy as np
import pytest
from core_closures import bed, closures, rectangle, solids
from gmsh_meshes import IN_3D, KINDS, geometry, sides, unstructured
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from test_core_exact import wen_yu

import contbed as cb
from contbed.mesh import build as meshing
from contbed.scene.mesh import MeshAxisymmetric
from contbed.two_fluid.boundary import (
    InletCondition,
    OutletCondition,
    WallCondition,
    symmetry,
)
from contbed.two_fluid.fv import grid
from contbed.two_fluid.model import Options
from tests.refusals import refused

LENGTH, HEIGHT = 0.06, 0.12
SLIP = symmetry()


SHAPES = ("quadrilateral", "triangle")


def grid_of(kind, length=LENGTH, height=HEIGHT):
    """A small grid: regular for one of the shapes, else of gmsh."""
    if kind in SHAPES:
        return rectangle(length, height, (4, 8), shape=kind)
    return unstructured(kind, length, height, 0.015)


@pytest.fixture(params=[*SHAPES, *KINDS])
def on(request):
    """A small grid of each kind."""
    return grid_of(request.param)


def upwards(on, speed):
    """Velocity along the last axis in all cells."""
    u = np.zeros((len(on.cells), on.dimension))
    u[:, -1] = speed
    return u


def gravity(on, g=9.81):
    """Gravity against the last axis."""
    return (*(0.0,) * (on.dimension - 1), -g)


def advance(b, steps):
    """That many steps by the Courant number."""
    for _ in range(steps):
        b.step(b.next_step())


# ---------------------------------------------------------------------- states that stay


def test_uniform_suspension_hangs_in_the_gas(on):
    # V3 asks for 1e-6 with slip walls; gradients, faces and gathering are exact for
    # what is linear, to rounding
    s, rho, mu, d_p = 0.4, 1.225, 1.7894e-5, 275e-6
    drag = wen_yu(rho, mu, d_p)
    u = brentq(lambda u: drag(s, u) * u - (1 - s) * (2500 - rho) * 9.81, 1e-6, 10)
    p = (HEIGHT - on.centres[:, -1]) * (s * 2500 + (1 - s) * rho) * 9.81
    ends = {"bottom": InletCondition((1 - s) * u), "top": OutletCondition()}
    b = bed(
        on, closures(drag), sides(on, SLIP, **ends), gravity(on), rho_gas=rho, mu_gas=mu
    )
    b.start(eps_s=s, u_gas=upwards(on, u), p=p)
    advance(b, 50)
    assert np.abs(b.state.u_solid).max() < 1e-10
    assert_allclose(b.state.u_gas, upwards(on, u), atol=1e-10)
    assert_allclose(b.state.p, p, rtol=1e-9)


def test_column_of_gas_rests(on):
    p = (HEIGHT - on.centres[:, -1]) * 1.2 * 9.81
    b = bed(
        on,
        closures(100.0),
        sides(on, WallCondition(), top=OutletCondition()),
        gravity(on),
    )
    b.start(p=p)
    advance(b, 20)
    assert np.abs(b.state.u_gas).max() < 1e-13
    assert_allclose(b.state.p, p, atol=1e-12)


@pytest.mark.parametrize(
    ("kind", "axis", "superficial", "most"),
    [
        ("quadrilateral", 1, 0.0, 1e-10),
        ("quadrilateral", 1, 0.03, 1e-10),
        # without gas to what V3 asks for; gas at the outlet that follows particles as
        # if they fell in from outside circulates at 1e-4 m/s
        ("triangles", 1, 0.0, 1e-10),
        ("triangles", 0, 0.0, 1e-10),
        ("axisymmetric_triangles", 1, 0.0, 1e-10),
        ("tetrahedra", 2, 0.0, 1e-10),
        # gas below minimum fluidization: forces that vary along the bed are curved to
        # second order; gradients that take the curvature for a slope move particles at
        # 5e-5 m/s
        ("triangles", 1, 0.03, 1e-6),
        ("triangles", 0, 0.03, 1e-6),
    ],
)
def test_packed_bed_rests_below_an_outlet(kind, axis, superficial, most):
    """Particles up to the outlet, carried by friction."""

    def ergun(eps_s, slip):
        return (
            150 * eps_s * 1.8e-5 / ((1 - eps_s) * 275e-6**2)
            + 1.75 * 1.2 * slip / 275e-6
        )

    along = axis == 0
    on = grid_of(kind, *((HEIGHT, LENGTH) if along else (LENGTH, HEIGHT)))
    laws = closures(ergun, 1.0, 0.05, 0.0, 0.01, 1e6, friction=400.0, rubbing=20.0)
    low, high = ("left", "right") if along else ("bottom", "top")
    b = bed(
        on,
        laws,
        sides(
            on,
            WallCondition("slip", "no_slip"),
            **{low: InletCondition(superficial), high: OutletCondition()},
        ),
        tuple(-9.81 * (np.arange(on.dimension) == axis)),
        Options(dt_max=2e-3),
    )
    b.start(eps_s=0.58, p=(HEIGHT - on.centres[:, axis]) * 1.2 * 9.81)
    b.advance(0.5)
    assert np.abs(b.state.u_solid).max() < most


def test_uniform_flow_stays_uniform(on):
    b = bed(
        on,
        closures(),
        sides(on, SLIP, bottom=InletCondition(1.0), top=OutletCondition()),
        gravity(on, 0.0),
    )
    b.start(u_gas=upwards(on, 1.0))
    advance(b, 20)
    assert_allclose(b.state.u_gas, upwards(on, 1.0), atol=1e-13)


def test_noise_fades(on):
    """Gas alone, with noise on its velocity: convection, projection and gathering
    amplify nothing, on flat cells too.

    Gradients from the few faces of a flat tetrahedron alone made noise grow tenfold a
    step.
    """
    b = bed(
        on,
        closures(),
        sides(on, SLIP, bottom=InletCondition(0.5), top=OutletCondition()),
        gravity(on, 0.0),
    )
    uniform = upwards(on, 0.5)
    b.start(
        u_gas=uniform + 0.02 * np.random.default_rng(1).standard_normal(uniform.shape)
    )
    advance(b, 10)
    before = np.abs(b.state.u_gas - uniform).max()
    advance(b, 100)
    assert np.abs(b.state.u_gas - uniform).max() < 0.5 * before


def test_homogeneous_cooling(on):
    # exact in any step (V1); theta stays uniform as far as iterations go
    e, s, d_p, g0, end = 0.95, 0.3, 150e-6, 4.84732, 0.005
    gamma = 12 * (1 - e**2) * g0 * 2500 / (d_p * np.sqrt(np.pi))
    laws = closures(0.0, 1.0, 0.1, 0.1, 0.1, dissipation=gamma)
    b = bed(on, laws, sides(on, SLIP), gravity(on, 0.0), Options(dt=1e-3))
    b.start(eps_s=s, theta=1e-2)
    b.advance(end)
    rate = 8 * (1 - e**2) * s * g0 / (d_p * np.sqrt(np.pi))
    assert_allclose(b.state.theta, 1e-2 / (1 + rate * 0.1 * end / 2) ** 2, rtol=1e-7)
    assert (
        np.ptp(b.state.theta) < 1e-7 * b.state.theta.mean()
        and np.abs(b.state.u_solid).max() < 1e-10
    )


# ---------------------------------------------------------------------- mass and momentum


def test_solids_are_kept_between_johnson_jackson_walls(on):
    """V8: 1e-12 of the mass, with what came in and went out; the flux of both phases
    has no divergence.
    """
    feed = InletCondition(1.0, eps_s=0.05, solid_flux=60.0, theta=1e-3)
    laws = closures(
        wen_yu(1.2, 1.8e-5, 275e-6),
        1.0,
        0.05,
        0.02,
        0.05,
        1e6,
        friction=400.0,
        rubbing=1.0,
    )
    wall = WallCondition("no_slip", "johnson_jackson", 0.1, 0.9)
    b = bed(on, laws, sides(on, wall, bottom=feed, top=OutletCondition()), gravity(on))
    noise = np.random.default_rng(2).uniform(-1, 1, len(on.cells))
    b.start(
        eps_s=0.3 * (1 + 0.1 * noise) * (on.centres[:, -1] < 0.05),
        u_gas=upwards(on, 1.0),
        theta=1e-4,
    )
    before = solids(b)
    for _ in range(60):
        b.step(b.next_step())
        assert (
            b.state.eps_s.min() >= 0
            and b.state.eps_s.max() <= 0.63
            and b.state.theta.min() >= 0
        )
    came = b.state.account.solid_in - b.state.account.solid_out
    assert solids(b) == pytest.approx(before + came, rel=1e-12)
    left = np.zeros(len(on.cells))
    np.add.at(left, on.geometry.left, b.state.fluxes.total)
    np.subtract.at(left, on.geometry.right, b.state.fluxes.total[: on.interior])
    assert np.abs(left).max() < 1e-12 * np.abs(b.state.fluxes.total).max()


def momentum_lost(on, drag=100.0):
    """Drift of the momentum of a lively periodic box in 0.01 s, over density times
    velocity.
    """
    size = np.array([LENGTH] * (on.dimension - 1) + [HEIGHT])
    x, volume = 2 * np.pi * on.centres / size, on.geometry.volume
    b = bed(
        on,
        closures(drag, 1.0, 0.2, 0.1, 0.1, 1e4),
        {},
        gravity(on, 0.0),
        Options(courant=0.3),
    )
    u = upwards(on, 0.1 * np.sin(x[:, 0]))
    u[:, 0] += 0.05 * np.cos(x[:, -1]) + 0.03
    b.start(eps_s=0.2 + 0.02 * np.sin(x[:, 0]), u_gas=u, u_solid=u, theta=1e-4)

    def momentum():
        s = b.state.eps_s[:, None]
        return volume @ (1.2 * (1 - s) * b.state.u_gas + 2500 * s * b.state.u_solid)

    before = momentum()
    b.advance(0.01)
    return np.abs(momentum() - before).max() / (
        2500 * solids(b) * np.abs(b.state.u_solid).max()
    )


PAIRS = [("left", "right"), ("bottom", "top")]


@pytest.mark.parametrize(("drag", "most"), [(0.0, 1e-14), (100.0, 1e-8)])
def test_momentum_of_a_periodic_box(drag, most):
    # forces on faces, gathered in cells, keep momentum to rounding where cells are
    # alike; drag on what faces do not see of the velocities is that on two separate
    # phases
    assert momentum_lost(rectangle(LENGTH, HEIGHT, (6, 12), PAIRS), drag) < most


@pytest.mark.parametrize("kind", ["quadrilaterals", "triangles"])
def test_momentum_of_unequal_cells(kind):
    # elsewhere as far as the mesh resolves
    for size in (0.015, 0.0075):
        assert momentum_lost(unstructured(kind, LENGTH, HEIGHT, size, PAIRS)) < 1e-5


# ---------------------------------------------------------------------- flows with closed forms


@pytest.mark.parametrize("shape", ["quadrilateral", "triangle"])
def test_gas_flow_in_a_pipe_is_parabolic(shape):
    R, mu, errors = 0.01, 0.1, []
    for cells in (6, 12, 24):
        pipe = MeshAxisymmetric(
            type="axisymmetric", length=R, radius=R, cells=(cells, cells), shape=shape
        )
        on = grid.build(meshing.build(pipe), [("bottom", "top")])
        exact = upwards(on, 1 - (on.centres[:, 0] / R) ** 2)
        b = bed(
            on,
            closures(),
            sides(on, WallCondition()),
            (0.0, 0.0),
            rho_gas=1.0,
            mu_gas=mu,
        )
        b.model.sources.force_gas[:, 1] = 4 * mu / R**2
        b.start(u_gas=exact)
        for _ in range(50):
            b.step(1e-4)
        errors.append(
            np.sqrt(on.geometry.volume @ ((b.state.u_gas - exact) ** 2).sum(axis=1))
        )
    assert (
        np.log2(errors[0] / errors[1]) > 1.8 and np.log2(errors[1] / errors[2]) > 1.8
    ), errors


# ---------------------------------------------------------------------- scenes

SCENE = """
[mesh]
{mesh}

[two_fluid]

[gas]
density = 1.225
viscosity = 1.7894e-5

[solids.beads]
diameter = "275 um"
density = 2500.0

[closures]
drag = "drag_gidaspow"

[initial]
gas.velocity = 0.46

[[initial.layer]]
end = 0.06
gas.velocity = 1.0
solids.beads.volume_fraction = 0.55

[boundary.bottom]
type = "inlet"
gas.velocity = 0.46

[boundary.top]
type = "outlet"

{sides}

[time]
end = {end}
average_from = 0.0

[output]
plots = false
"""
WALL = """
[boundary.{}]
type = "wall"
solids.beads = {{ wall = "johnson_jackson", specularity = 0.01, restitution = 0.9 }}
"""
CYLINDER = """
SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 0, 0, 0.12, 0.03};
Mesh.MeshSizeMax = 0.016;
Mesh.MeshSizeMin = 0.016;
Physical Surface("wall", 1) = {1};
Physical Surface("top", 2) = {2};
Physical Surface("bottom", 3) = {3};
Physical Volume("bed", 4) = {1};
"""


def scene(folder, text, dimension, boundaries, end=0.01, extra=""):
    """A scene with a geometry of gmsh beside it."""
    (folder / "bed.geo").write_text(text)
    mesh = f'type = "file"\nfile = "bed.geo"\ndimension = {dimension}\n{extra}'
    (folder / "bed.toml").write_text(SCENE.format(mesh=mesh, sides=boundaries, end=end))
    return cb.load(folder / "bed.toml", trust=True)


@pytest.mark.parametrize("kind", [*KINDS, "cylinder"])
def test_scene_from_gmsh(kind, tmp_path):
    """Files and tables of a scene on each kind of mesh: cells in place, profiles by
    position.
    """
    round_axis, in_3d = kind.startswith("axi"), kind in (*IN_3D, "cylinder")
    names = (
        ["wall"]
        if round_axis or kind == "cylinder"
        else ["left", "right"] + ["front", "back"] * in_3d
    )
    text = (
        CYLINDER
        if kind == "cylinder"
        else geometry(kind, LENGTH, HEIGHT, 0.015 if in_3d else 0.012)
    )
    walls = "".join(WALL.format(name) for name in names)
    there = scene(
        tmp_path, text, 2 + in_3d, walls, extra="axisymmetric = true" * round_axis
    )
    result = cb.run(there, tmp_path / "out")
    assert abs(result.qoi["mass_drift_relative"]) < 1e-12
    # of whole cells
    assert result.qoi["weight_of_solids"] == pytest.approx(
        0.55 * 0.06 * 2500 * 9.81, rel=0.15
    )
    files = meshio.read(sorted((tmp_path / "out").glob("fields_*.vtu"))[-1])
    corners = files.points[files.cells[0].data]
    if kind == "hexahedra":
        # edges of these cells stand or lie; between corners in a wrong order there are
        # diagonals
        edges = (
            corners[:, [0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3]]
            - corners[:, [1, 2, 3, 0, 5, 6, 7, 4, 4, 5, 6, 7]]
        )
        along, up = np.linalg.norm(edges[..., :2], axis=-1), np.abs(edges[..., 2])
        assert np.minimum(along, up).max() < 1e-9
    middle = corners[..., result.plan.grid.dimension - 1].mean(axis=1)
    dense = files.cell_data["eps_s"][0] > 0.3
    assert dense.any() and middle[dense].max() < 0.08
    axial, lateral = result.tables["axial"], result.tables["lateral"]
    assert next(iter(lateral)) == (
        "r [m]" if round_axis or kind == "cylinder" else "x [m]"
    )
    for table in (axial, lateral):
        place = next(iter(table.values()))
        assert 1 < len(place) <= 15 and (np.diff(place) > 0).all()
    height, eps = axial["height [m]"], axial["eps_s [1]"]
    assert (eps[height < 0.03] > 0.4).all() and (eps[height > 0.08] < 0.05).all()


def test_periodic_pair_and_piece_of_a_side(tmp_path):
    feed = (
        '[boundary.feed]\non = "left"\nstart = 0.07\nend = 0.1\ntype = "inlet"\n'
        "solids.beads = { volume_fraction = 0.2, mass_flux = 20.0 }\n"
    )
    walls = WALL.format("left") + WALL.format("right")
    result = cb.run(
        scene(tmp_path, geometry("triangles", LENGTH, HEIGHT, 0.012), 2, walls + feed)
    )
    # two faces of 12 mm have their middles between 0.07 and 0.1 m
    assert result.balances["solids"]["in"] == pytest.approx(
        20.0 * 0.024 * 0.01, rel=1e-9
    )
    periodic = '[boundary.left]\ntype = "periodic"\npartner = "right"\n'
    result = cb.run(
        scene(tmp_path, geometry("triangles", LENGTH, HEIGHT, 0.012), 2, periodic)
    )
    assert list(result.plan.grid.boundaries) == ["bottom", "top"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ('Physical Curve("left", 4) = {4};', ""),
            "exterior facets are in no Physical Curve",
        ),
        (
            (
                "Periodic Curve {2} = {-4} Translate {0.06, 0, 0};",
                "Transfinite Curve {2} = 8;",
            ),
            "mesh both sides alike",
        ),
    ],
)
def test_meshes_that_cannot_be_used(change, message, tmp_path):
    text = geometry("triangles", LENGTH, HEIGHT, 0.012)
    assert change[0] in text
    refused(
        message,
        lambda: cb.run(
            scene(
                tmp_path,
                text.replace(*change),
                2,
                '[boundary.left]\ntype = "periodic"\npartner = "right"\n',
            )
        ),
    )


@pytest.mark.parametrize(
    ("sides", "message"),
    [
        (
            '[boundary.left]\ntype = "periodic"\npartner = "rihgt"',
            r"bed.toml:\d+: .*no 'rihgt', only bottom, right, top",
        ),
        (WALL.format("left") + WALL.format("rigth"), "no 'rigth'"),
        (WALL.format("left"), "boundary.right: missing"),
        (
            WALL.format("left")
            + WALL.format("right")
            + WALL.format("port")
            + 'on = "left"\nstart = 0.05\nend = 0.0501',
            "port: holds no face of 'left', which reaches from 0 m to 0.12 m with 10 "
            "faces; refine",
        ),
        (
            WALL.format("left")
            + WALL.format("right")
            + WALL.format("port")
            + 'on = "left"\nstart = -1.0\nend = 1.0',
            "port: holds all faces of 'left'",
        ),
    ],
)
def test_boundaries_that_the_mesh_lacks(sides, message, tmp_path):
    refused(
        message,
        lambda: cb.run(
            scene(tmp_path, geometry("triangles", LENGTH, HEIGHT, 0.012), 2, sides)
        ),
    )
