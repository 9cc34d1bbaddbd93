"""Beds of two fluids for runs on ranks: the check cases, and a bed that moves on
each kind of mesh.
"""

from pathlib import Path
from typing import Any

from tests.scene_text import changed, scene_of, set_keys

CHECKS = Path(__file__).parents[2] / "studies" / "two_fluid_checks"
CHECK_CASES = (
    "closed_box_jj",
    "cooling",
    "cooling_drag",
    "crossing",
    "fixed_bed",
    "heating",
    "rest",
    "riemann",
    "settling",
    "shear",
    "slip",
    "uniform_gidaspow",
    "uniform_syamlal",
    "uniform_wenyu",
)
JET = scene_of("""
model = "two_fluid"
mesh = { type = "rectangle", length = 0.04, height = 0.1, cells = [10, 25] }

[closures]
drag = "drag_gidaspow"
friction_viscosity = "friction_viscosity_schaeffer"

[gas]
density = 1.2
viscosity = 1.8e-5

[solids.beads]
diameter = 5e-4
density = 2500.0
restitution = 0.9
packing_limit = 0.63

[initial]
solids.beads = { granular_temperature = 1e-3 }
noise = 0.02
layer = [{ end = 0.06, solids = { beads = { volume_fraction = 0.58, velocity = 0.1 } } }]

[boundary]
bottom.type = "inlet"
bottom.gas = { velocity = 0.8 }
top.type = "outlet"
left.type = "wall"
left.solids.beads.wall = "johnson_jackson"
left.solids.beads.specularity = 0.05
left.solids.beads.restitution = 0.9
right.type = "wall"

[time]
end = 0.05
sample = 0.01
first = 5e-4
longest = 1e-3

[output]
plots = false
""")
# the gas conducts so well that its conduction is implicit
HEAT = """
    heat = {}
    gas.heat_capacity = 1005.0
    gas.conductivity = 0.03
    gas.density_law = "ideal_gas"
    solids.beads.heat_capacity = 800.0
    two_fluid.conductivity_gas = 2.0
    two_fluid.conductivity_solids = 1.0
    initial.gas.temperature = 300.0
    initial.solids.beads.temperature = 310.0
    boundary.left.temperature = 500.0
    boundary.right.heat_flux = 2e4
"""
TRIANGLES = 'mesh.shape = "triangle"\n'
HOT_TRIANGLES = (
    TRIANGLES
    + HEAT
    + "boundary.bottom.gas.temperature = 600.0\nsolids.beads.emissivity = 0.9\nradiation = {}\n"
)
CLOSED = """
    boundary.bottom = { type = "wall" }
    boundary.top = { type = "wall" }
"""
ROUND = """
    mesh = { type = "axisymmetric", radius = 0.02, length = 0.1, cells = [6, 25], shape = "triangle" }
"""
BOX = """
    mesh = { type = "box", length = 0.03, width = 0.02, height = 0.08, cells = [3, 2, 8] }
    boundary.front = { type = "wall" }
    boundary.back = { type = "wall" }
"""


def bed(text: str, without: tuple[str, ...] = ()) -> dict[str, Any]:
    """The jet with the values of the keys of a text, and without others."""
    scene = changed(JET, without=without)
    set_keys(scene, text)
    return scene


BEDS = {
    "rectangles": bed(""),
    "triangles": bed(TRIANGLES),
    # steps of 1 ms let theta alternate from one to the next, which multiplies rounding
    "triangles_algebraic": bed(
        TRIANGLES
        + """
        two_fluid.granular_temperature = "algebraic"
        time.first = 2.5e-4
        time.longest = 5e-4
        """
    ),
    "triangles_around_an_axis": bed(ROUND, ("boundary.left", "boundary.right")),
    "periodic": bed(
        'boundary.left = { type = "periodic", partner = "right" }', ("boundary.right",)
    ),
    "tetrahedra": bed(
        BOX
        + """
        mesh.shape = "tetrahedron"
        time.first = 1e-4
        time.longest = 1e-4
        """
    ),
    "hexahedra": bed(BOX),
    "factors_near_walls": bed('closures.drag = "igci"\nclosures.wall_drag = "igci"'),
    "closed": bed(TRIANGLES + CLOSED),
    "heated": bed(HOT_TRIANGLES),
    "heated_closed": bed(TRIANGLES + HEAT + CLOSED),
    "heated_rectangles": bed(
        HEAT
        + """
        boundary.bottom.gas.temperature = 600.0
        gas.density_law = "constant"
        two_fluid.conductivity_gas = 0.05
        """
    ),
    "pulse": bed(
        HOT_TRIANGLES
        + """
        boundary.pulse = { type = "inlet", on = "bottom", start = 0.012, end = 0.028, until = 0.02 }
        boundary.pulse.gas = { velocity = 2.0, temperature = 900.0 }
        """
    ),
    "averaged": bed(TRIANGLES + "time.average_from = 0.012\ntime.fields = 0.02"),
}
BEDS["triangles_around_an_axis"]["boundary"]["wall"] = JET["boundary"]["left"]
