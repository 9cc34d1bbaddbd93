"""Where the flow of a mesh file is plug flow: no wall may stand in its way."""

import math
import re
from itertools import pairwise

import numpy as np
import pytest
import skfem
from pytest import approx

import contbed as cb
from contbed.loading import loads
from contbed.mesh.mesh import Mesh
from contbed.models import plan
from contbed.packed_bed.curved_inlet import outward_normals
from contbed.packed_bed.flow import is_along, passes_along
from tests.refusals import refused

MSH = """\
$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
5
1 1 "in"
1 2 "out"
1 3 "floor"
1 4 "roof"
2 5 "bed"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 1 0 0
3 1 HEIGHT 0
4 0 1 0
$EndNodes
$Elements
6
1 1 2 1 1 4 1
2 1 2 2 2 2 3
3 1 2 3 3 1 2
4 1 2 4 4 3 4
5 2 2 5 5 1 2 3
6 2 2 5 5 1 3 4
$EndElements
"""
BED = """
[gas]
density = 1.2
viscosity = 1.8e-5
[solids.beads]
diameter = 0.005
density = 2500
[packed_bed]
porosity = 0.4
"""
SCENE = f"""
[mesh]
type = "file"
file = "duct.msh"
dimension = 2
{BED}
[boundary.in]
type = "inlet"
gas.velocity = [0.2, 0.0]
[boundary.out]
type = "outlet"
[boundary.roof]
type = "ROOF"
"""


def duct(folder, height, roof):
    (folder / "duct.msh").write_text(MSH.replace("HEIGHT", f"{height}"))
    return plan(loads(SCENE.replace("ROOF", roof), "scene.toml", base=folder))


def test_a_duct_of_one_width_has_plug_flow_and_a_cone_has_not(tmp_path):
    assert duct(tmp_path, 1.0, "slip").plug
    assert not duct(tmp_path, 0.5, "no_slip").plug


def test_an_oblique_slip_wall_is_refused_before_the_run(tmp_path):
    """Its plug flow kept the velocity of the inlet in half of the section."""
    refused("scene.toml: boundary.roof: a slip wall", duct, tmp_path, 0.5, "slip")


def test_a_plane_in_the_way_of_the_flow_is_no_refusal():
    mesh = skfem.MeshTri().refined(1)
    named = mesh.with_boundaries(
        {"right": lambda x: x[0] == 1.0, "top": lambda x: x[1] == 1.0}
    )
    assert is_along(Mesh(named), "top", [1.0, 0.0])
    assert not is_along(Mesh(named), "right", [1.0, 0.0])


def ring_file(points):
    """Return a gmsh file of triangles between two rows of points (across, along, 2):
    inner side, outer side, and both ends under one name.
    """
    across, along = points.shape[:2]
    number = 1 + np.arange(across * along).reshape(across, along)
    nodes = "\n".join(
        f"{n} {x:.17g} {y:.17g} 0" for n, (x, y) in enumerate(points.reshape(-1, 2), 1)
    )
    sides = {1: number[0], 2: number[-1]}
    lines = [(name, *pair) for name, row in sides.items() for pair in pairwise(row)]
    lines += [(3, *pair) for end in (0, -1) for pair in pairwise(number[:, end])]
    triangles = []
    for low, high in pairwise(number):
        for (a, b), (c, d) in zip(pairwise(low), pairwise(high), strict=True):
            triangles += [(a, c, d), (a, d, b)]
    rows = [f"1 2 {name} {name} {a} {b}" for name, a, b in lines]
    rows += [f"2 2 4 4 {a} {b} {c}" for a, b, c in triangles]
    elements = "\n".join(f"{n} {row}" for n, row in enumerate(rows, 1))
    return (
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n"
        '1 1 "inner"\n1 2 "outer"\n1 3 "ends"\n2 4 "bed"\n$EndPhysicalNames\n'
        f"$Nodes\n{number.size}\n{nodes}\n$EndNodes\n"
        f"$Elements\n{len(rows)}\n{elements}\n$EndElements\n"
    )


def annulus(cells):
    """Return a ring from 0.1 to 0.4 m in (r, z), one cell high."""
    r, z = np.meshgrid(np.linspace(0.1, 0.4, cells + 1), [0.0, 0.1], indexing="ij")
    return ring_file(np.stack([r, z], -1))


def quarter(cells):
    """Return a quarter of a ring from 0.1 to 0.4 m in (x, y)."""
    r, angle = np.meshgrid(
        np.geomspace(0.1, 0.4, cells + 1),
        np.linspace(0.0, 0.5 * np.pi, cells + 1),
        indexing="ij",
    )
    return ring_file(np.stack([r * np.cos(angle), r * np.sin(angle)], -1))


def test_a_bed_at_rest_conducts_through_curved_sides(tmp_path):
    """Heat through a quarter of a ring, k dT (pi/2)/ln 4 for each metre of depth; no
    side needs a type without flow. Chords of 24 cells miss the arc by 0.1 %.
    """
    (tmp_path / "quarter.msh").write_text(quarter(24))
    scene = SCENE.partition("[boundary.in]")[0].replace("duct.msh", "quarter.msh")
    scene = scene.replace(
        "viscosity", "heat_capacity = 1e3\nconductivity = 0.03\nviscosity"
    )
    scene = scene.replace(
        "density = 2500", "density = 2500\nheat_capacity = 900\nconductivity = 1"
    )
    scene += (
        "[heat]\n[closures]\nnusselt = 10\nconductivity_gas = 0\n"
        "conductivity_solids = 0.3\n[output]\npositions = [0.08, 0.25]\nacross = [0.1]\n"
        "[boundary.inner]\nsolids.beads.fixed_temperature = 500\n"
        "[boundary.outer]\nsolids.beads.fixed_temperature = 300\n"
    )
    qoi = cb.run(loads(scene, "quarter.toml", base=tmp_path)).qoi
    wanted = 0.3 * 200.0 * 0.5 * math.pi / math.log(4.0)
    assert qoi["heat_inner_W"] == approx(wanted, rel=2e-3)
    assert qoi["heat_ends_W"] == 0.0


def test_a_radial_bed_has_the_pressure_drop_of_its_ring(tmp_path):
    """u = u_o R/r, and dp = int a u + b u^2 dr = a u_o R ln(R/r) + b (u_o R)^2 (1/r -
    1/R) with Ergun's a and b; cells of 7.5 mm miss it by 0.8 %.
    """
    (tmp_path / "ring.msh").write_text(annulus(40))
    scene = SCENE.partition("[boundary.in]")[0].replace("duct.msh", "ring.msh")
    scene = scene.replace("dimension = 2", "dimension = 2\naxisymmetric = true")
    scene += (
        '[boundary.outer]\ntype = "inlet"\ngas.velocity = [-0.2, 0.0]\n'
        '[boundary.inner]\ntype = "outlet"\n[boundary.ends]\ntype = "slip"\n'
    )
    qoi = cb.run(loads(scene, "ring.toml", base=tmp_path)).qoi
    a = 150.0 * 1.8e-5 * 0.6**2 / (0.4**3 * 0.005**2)
    b = 1.75 * 1.2 * 0.6 / (0.4**3 * 0.005)
    flow = 0.2 * 0.4
    drop = a * flow * math.log(4.0) + b * flow**2 * (1 / 0.1 - 1 / 0.4)
    assert qoi["pressure_drop_Pa"] == approx(drop, rel=0.01)
    assert qoi["u_max_outlet"] == approx(0.8, rel=0.01)


CORNER = f"""
[mesh]
type = "rectangle"
length = 0.4
height = 0.2
cells = [8, 4]
{BED}
[boundary.left]
type = "inlet"
gas.velocity = 0.2
[boundary.top]
type = "outlet"
"""


def test_an_outlet_beside_the_flow_is_no_plug_flow():
    """What enters leaves through the top, not through the closed side that it meets."""
    told = r'scene.toml: boundary.right: the flow meets it.*"no_slip" or "symmetry"'
    refused(told, lambda: plan(loads(CORNER)))
    closed = '[boundary.right]\ntype = "slip"\n'
    result = cb.run(loads(CORNER + closed))
    assert not result.plan.plug
    volume = result.balances["fluid volume"]
    assert volume["in"] == approx(0.2 * 0.2, rel=1e-12)
    assert volume["out"] == approx(0.2 * 0.2, rel=1e-9)
    assert result.qoi["u_max_outlet"] > 0.2


CYLINDER = """
SetFactory("OpenCASCADE");
{shape}
Mesh.MeshSizeMax = 0.012;
Physical Surface("wall") = {{1}};
Physical Surface("top") = {{2}};
Physical Surface("bottom") = {{3}};
Physical Volume("bed") = {{1}};
"""
HEATED = """
mesh = { type = "file", file = "tube.geo", dimension = 3 }
gas = { density = 1.1, viscosity = 2e-5, heat_capacity = 1000, conductivity = 0.03 }
packed_bed.porosity = 0.4
solids.balls = { diameter = "3 mm", conductivity = 1.0, density = 2500, heat_capacity = 800 }
closures.nusselt = "wakao_kaguei"
heat = {}
[boundary.bottom]
gas = { velocity = 0.5, temperature = 300 }
[boundary.wall]
heat_flux = 2000
"""


def tube(folder, shape):
    (folder / "tube.geo").write_text(CYLINDER.format(shape=shape))
    (folder / "scene.toml").write_text(HEATED)
    return cb.load(folder / "scene.toml", trust=True)


def test_triangles_on_a_round_wall_are_along_the_flow(tmp_path):
    """Their normals are tilted by up to 4 degrees. The heat of the wall is its flux
    times the area of the triangles, all of which leaves with the gas: to 0.1 %, by
    which their tilts let heat pass.
    """
    scene = tube(tmp_path, "Cylinder(1) = {0, 0, 0, 0, 0, 0.08, 0.03};")
    made = plan(scene)
    axis = np.array([0.0, 0.0, 1.0])
    sections = [
        np.abs(
            outward_normals(made.mesh.skfem, made.mesh.skfem.boundaries[name]) @ axis
        )
        for name in ("wall", "bottom")
    ]
    assert sections[0].sum() > 0.01 * sections[1].sum()  # tilted they are
    assert passes_along(made.mesh, "wall", axis)
    for degrees in (2.0, -2.0):
        aside = np.array([math.tan(math.radians(degrees)), 0.0, 1.0])
        assert not passes_along(made.mesh, "wall", aside)
    result = cb.run(scene)
    area = 2.0 * math.pi * 0.03 * 0.08
    assert result.qoi["heat_wall_W"] == approx(2000.0 * area, rel=0.01)  # of a polygon
    assert result.qoi["duty_W"] == approx(result.qoi["heat_wall_W"], rel=1e-3)


def test_a_cone_is_not_along_the_flow(tmp_path):
    refused(
        "neither along nor across",
        lambda: plan(tube(tmp_path, "Cone(1) = {0, 0, 0, 0, 0, 0.08, 0.03, 0.028};")),
    )


CHANNEL = """
Point(1) = {{0, 0, 0, {size}}};
Point(2) = {{0.2, 0, 0, {size}}};
Point(3) = {{0.2, 0.04, 0, {size}}};
Point(4) = {{0, 0.04, 0, {size}}};
Line(1) = {{1, 2}};
Line(2) = {{2, 3}};
Line(3) = {{3, 4}};
Line(4) = {{4, 1}};
Curve Loop(1) = {{1, 2, 3, 4}};
Plane Surface(1) = {{1}};
Physical Curve("walls") = {{1, 3}};
Physical Curve("right") = {{2}};
Physical Curve("left") = {{4}};
Physical Surface("bed") = {{1}};
"""
BETWEEN_WALLS = """
mesh = { type = "file", file = "channel.geo" }
gas = { density = 1.0, viscosity = 2e-5 }
packed_bed.porosity = 0.4
solids.balls.diameter = "3 mm"
closures = { permeability = 1e-8, forchheimer = 0 }
boundary.left.gas.velocity = 0.1
boundary.walls.type = "no_slip"
"""


def channel(folder, size):
    """Run the channel on cells of a size [m]."""
    (folder / "channel.geo").write_text(CHANNEL.format(size=size))
    (folder / "scene.toml").write_text(BETWEEN_WALLS)
    return cb.run(cb.load(folder / "scene.toml", trust=True))


@pytest.mark.parametrize("size", [0.01, 0.005])
def test_cells_that_miss_the_layer_at_a_wall_bring_a_warning(tmp_path, size):
    """Against the closed form of Brinkman's flow between planes, to a third: where the
    flow enters it is that of the scene also beside the walls.
    """
    result = channel(tmp_path, size)
    heights = 0.02 / math.sqrt(1e-8 / 0.4)  # over the thickness of the layer
    exact = 2e-5 / 1e-8 * 0.1 * 0.2 / (1.0 - math.tanh(heights) / heights)
    wrong = result.qoi["pressure_drop_Pa"] / exact - 1.0
    (text,) = [each for each in result.warnings if "boundary.walls: the layer" in each]
    told = float(re.search(r"about ([0-9.]+)% too high", text)[1]) / 100.0
    assert told == approx(wrong, rel=1 / 3) and wrong > 0.01


def test_thin_cells_at_walls_bring_no_warning(tmp_path):
    assert not channel(tmp_path, 0.0015).warnings


ELBOW = """
Point(1) = {0, 0, 0, 0.01}; Point(2) = {0.4, 0, 0, 0.01};
Point(3) = {0.4, 0.4, 0, 0.01}; Point(4) = {0.3, 0.4, 0, 0.01};
Point(5) = {0.3, 0.1, 0, 0.002}; Point(6) = {0, 0.1, 0, 0.01};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5};
Line(5) = {5, 6}; Line(6) = {6, 1};
Curve Loop(1) = {1, 2, 3, 4, 5, 6};
Plane Surface(1) = {1};
Physical Curve("inlet") = {6};
Physical Curve("outlet") = {3};
Physical Curve("walls") = {1, 2, 4, 5};
Physical Surface("bed") = {1};
"""


@pytest.mark.parametrize("walls", ["", 'boundary.walls.type = "wall"'])
def test_walls_of_an_elbow_have_one_name(tmp_path, walls):
    """Darcy's flow through two arms of 3 squares and a corner of 1 - (2/pi) ln 2 squares
    (Hall 1968, Thin Solid Films 1, 277); cells miss it by less than 1e-3.
    """
    (tmp_path / "elbow.geo").write_text(ELBOW)
    scene = BETWEEN_WALLS.replace("channel.geo", "elbow.geo")
    scene = scene.replace("left.gas.velocity = 0.1", "inlet.gas.velocity = 1e-3")
    scene = scene.partition("boundary.walls")[0]
    (tmp_path / "scene.toml").write_text(
        f'{scene}boundary.outlet.type = "outlet"\n{walls}\n'
    )
    result = cb.run(cb.load(tmp_path / "scene.toml", trust=True))
    squares = 3.0 + 3.0 + 1.0 - 2.0 / math.pi * math.log(2.0)
    drop = squares * 2e-5 / 1e-8 * 1e-3 * 0.1
    assert result.qoi["pressure_drop_Pa"] == approx(drop, rel=1e-3)
    assert result.balances["fluid volume"]["out"] == approx(1e-4, rel=1e-9)


TILTED = """
p = Pi/6;
Point(1) = {{0, 0, 0, {size}}};
Point(2) = {{0.5 * Cos(p), 0.5 * Sin(p), 0, {size}}};
Point(3) = {{0.5 * Cos(p) - 0.1 * Sin(p), 0.5 * Sin(p) + 0.1 * Cos(p), 0, {size}}};
Point(4) = {{-0.1 * Sin(p), 0.1 * Cos(p), 0, {size}}};
Line(1) = {{1, 2}}; Line(2) = {{2, 3}}; Line(3) = {{3, 4}}; Line(4) = {{4, 1}};
Curve Loop(1) = {{1, 2, 3, 4}};
Plane Surface(1) = {{1}};
Physical Curve("floor") = {{1}};
Physical Curve("outlet") = {{2}};
Physical Curve("roof") = {{3}};
Physical Curve("inlet") = {{4}};
Physical Surface("bed") = {{1}};
"""


@pytest.mark.parametrize("heated", [False, True])
def test_a_tilted_duct_has_the_drop_of_its_length(tmp_path, heated):
    """Ergun's drop over 0.5 m, though the profile is a line across: round-off."""
    (tmp_path / "tilted.geo").write_text(TILTED.format(size=0.02))
    scene = HEATED.replace("tube.geo", "tilted.geo").replace(
        "dimension = 3", "dimension = 2"
    )
    scene = scene.replace("boundary.bottom", "boundary.inlet").replace(
        "wall]", "floor]"
    )
    scene = scene.replace("velocity = 0.5", "velocity = 0.5").replace(
        "2000", "2000" if heated else "0"
    )
    scene += '[boundary.outlet]\ntype = "outlet"\n'
    (tmp_path / "scene.toml").write_text(scene)
    qoi = cb.run(cb.load(tmp_path / "scene.toml", trust=True)).qoi
    gradient = 150.0 * 2e-5 * 0.6**2 * 0.5 / (0.4**3 * 0.003**2)
    gradient += 1.75 * 1.1 * 0.6 * 0.25 / (0.4**3 * 0.003)
    assert qoi["pressure_drop_Pa"] == approx(0.5 * gradient, rel=1e-9)
    assert qoi["residence_time_s"] == approx(0.4 * 0.5 / 0.5, rel=1e-9)


def test_particles_pass_through_no_wall(tmp_path):
    """They went through the roof of a cone, and its heat was what they carried."""
    heat = "\n[heat]\n[closures]\nnusselt = 4\n"
    scene = SCENE.replace('type = "ROOF"', "coefficient = 20\nambient = 300").replace(
        "viscosity", "heat_capacity = 1e3\nconductivity = 0.03\nviscosity"
    )
    scene = scene.replace(
        "density = 2500", "density = 2500\nheat_capacity = 900\nconductivity = 1"
    )
    scene = scene.replace(
        "gas.velocity = [0.2, 0.0]",
        "gas = { velocity = [0.2, 0.0], temperature = 300 }\n"
        "solids.beads = { velocity = [1e-3, 0.0], temperature = 500 }",
    )
    (tmp_path / "duct.msh").write_text(MSH.replace("HEIGHT", "0.5"))
    refused(
        "boundary.roof: the particles move alike everywhere",
        lambda: plan(loads(scene + heat, "scene.toml", base=tmp_path)),
    )
