"""Where the flow of a mesh file is plug flow: no wall may stand in its way."""

import skfem

from contbed.loading import loads
from contbed.mesh.mesh import Mesh
from contbed.models import plan
from contbed.packed_bed.flow import is_along
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
SCENE = """
[mesh]
type = "file"
file = "duct.msh"
dimension = 2
[gas]
density = 1.2
viscosity = 1.8e-5
[solids.beads]
diameter = 0.005
density = 2500
[packed_bed]
porosity = 0.4
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
