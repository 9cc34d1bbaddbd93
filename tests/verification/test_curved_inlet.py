"""A gas that enters along the normals of a curved boundary, or beside an oblique wall:
pressure drop and temperature of radial flows, volumes, and what is refused.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

import contbed as cb
from contbed.loading import load
from contbed.models import plan
from tests.balances import assert_closed
from tests.refusals import refused

SCENE = Path(__file__).with_name("curved_inlet.toml")
INNER, OUTER, SPEED = 0.05, 0.2, 0.2  # m, m, m/s
DENSITY, VISCOSITY, DIAMETER, POROSITY = 1.2, 1.8e-5, 3e-3, 0.4
RING = """
Point(1) = {0, 0, 0, 0.01};
Point(2) = {0.05, 0, 0, 0.005};
Point(3) = {0.2, 0, 0, 0.015};
Point(4) = {0, 0.2, 0, 0.015};
Point(5) = {0, 0.05, 0, 0.005};
Line(1) = {2, 3};
Circle(2) = {3, 1, 4};
Line(3) = {4, 5};
Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Curve("core") = {4};
Physical Curve("shell") = {2};
Physical Curve("floor") = {1};
Physical Curve("side") = {3};
Physical Surface("bed") = {1};
"""
BALL = """
SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 0.2, 0, Pi/2, Pi/2};
Sphere(2) = {0, 0, 0, 0.05, 0, Pi/2, Pi/2};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Mesh.MeshSizeMax = 0.018;
sides() = Boundary{ Volume{3}; };
For k In {0:#sides()-1}
  box() = BoundingBox Surface{sides(k)};
  If (box(3) < 0.1 && box(4) < 0.1)
    Physical Surface("core") = {sides(k)};
  ElseIf (box(5) < 0.1)
    Physical Surface("floor") = {sides(k)};
  ElseIf (box(4) < 0.1)
    Physical Surface("side") = {sides(k)};
  ElseIf (box(3) < 0.1)
    Physical Surface("back") = {sides(k)};
  Else
    Physical Surface("shell") = {sides(k)};
  EndIf
EndFor
Physical Volume("bed") = {3};
"""


def scene(folder, geometry, **keys):
    """The scene with a geometry in a folder, and keys of its own."""
    path = folder / "bed.toml"
    path.write_text(SCENE.read_text())
    (folder / "bed.geo").write_text(geometry)
    return load(path, overrides=keys, trust=True)


def drop(power, speed=SPEED):
    """Ergun's pressure drop of a flow from the inner radius to the outer, whose speed
    falls with a power of the radius, less the momentum that the gas loses [Pa].
    """
    solid = 1.0 - POROSITY
    viscous = 150.0 * VISCOSITY * solid**2 / (POROSITY**3 * DIAMETER**2)
    inertial = 1.75 * DENSITY * solid / (POROSITY**3 * DIAMETER)

    def gradient(r):
        u = speed * (INNER / r) ** power
        return (viscous + inertial * u) * u

    slowed = speed**2 * (1.0 - (INNER / OUTER) ** (2 * power))
    return quad(gradient, INNER, OUTER)[0] - 0.5 * DENSITY * slowed / POROSITY**2


def test_a_quarter_of_a_ring(tmp_path):
    """0.1 % of the pressure drop, the arc by straight edges; the volume that enters is
    the speed times their length, and the temperature that of the gas.
    """
    heated = {"heat": {}, "closures.nusselt": 10.0}
    entering = {"boundary.core.gas.temperature": 350.0}
    made = scene(tmp_path, RING, **heated, **entering)
    result = cb.run(made)
    assert result.qoi["pressure_drop_Pa"] == pytest.approx(drop(1), rel=1e-3)
    mesh = result.plan.mesh.skfem
    edges = mesh.p[:, mesh.facets[:, mesh.boundaries["core"]]]
    length = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=0).sum()
    volume = result.balances["fluid volume"]
    units = [result.balances[name]["unit"] for name in ("fluid volume", "energy")]
    assert units == ["m3/s/m", result.units["duty_W"]] == ["m3/s/m", "W/m"]
    assert volume["in"] == pytest.approx(SPEED * length, rel=1e-12)
    assert_closed(result, 1e-12, "fluid volume")
    assert_closed(result, 1e-10, "energy")
    assert result.qoi["T_fluid_out_K"] == pytest.approx(350.0, rel=1e-9)
    (note,) = result.warnings
    assert "no line lies in the mesh from end to end" in note


WEDGE = """
Point(1) = {0, 0, 0, 0.02};
Point(2) = {0.3, 0, 0, 0.04};
Point(3) = {0.3, 0.25, 0, 0.04};
Point(4) = {0, 0.1, 0, 0.02};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Curve("floor") = {1};
Physical Curve("shell") = {2};
Physical Curve("side") = {3};
Physical Curve("core") = {4};
Physical Surface("bed") = {1};
"""


def test_nothing_crosses_an_oblique_wall_beside_the_inlet(tmp_path):
    """A channel that widens: 0.5 m/s through 0.1 m enter, to rounding, and heat by the
    wall alone is what the gas takes up.
    """
    hot = {"coefficient": 20.0, "ambient": 400.0}
    result = cb.run(
        scene(
            tmp_path,
            WEDGE,
            **{
                "boundary.core.gas": {"velocity": [0.5, 0.0], "temperature": 300.0},
                "boundary.side": {"type": "no_slip", "gas": hot},
                "heat": {},
                "closures.nusselt": 10.0,
            },
        )
    )
    assert result.balances["fluid volume"]["in"] == pytest.approx(0.05, rel=1e-12)
    assert result.qoi["heat_side_W"] == pytest.approx(result.qoi["duty_W"], rel=1e-9)


@pytest.mark.slow
def test_an_eighth_of_a_ball(tmp_path):
    """2 % of the pressure drop of the volume that enters through the facets, which have
    3 % less area than the sphere.
    """
    back = {"mesh.dimension": 3, "boundary.back": {"type": "slip"}}
    result = cb.run(scene(tmp_path, BALL, **back))
    entering = result.balances["fluid volume"]["in"] / (0.5 * np.pi * INNER**2)
    assert entering == pytest.approx(SPEED, rel=0.04)
    assert result.qoi["pressure_drop_Pa"] == pytest.approx(drop(2, entering), rel=0.02)
    assert_closed(result, 1e-12, "fluid volume")


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"boundary.core.gas.velocity": -0.2}, "is curved, and the gas leaves"),
        (
            {
                "boundary.core.gas.velocity": [0.1, 0.0],
                "boundary.core.solids.beads.velocity": 1e-3,
                "boundary.core.type": "inlet",
            },
            "is curved, and solids move as one body",
        ),
        (
            {"boundary.side": {"type": None}},
            "boundary.side: the gas enters through 'core'",
        ),
        (
            {
                "boundary.core.gas.velocity": {"times": [0, 1], "values": [0.1, 0.2]},
                "boundary.core.gas.temperature": 300.0,
                "heat": {},
                "closures.nusselt": 10.0,
                "time.end": 2.0,
                "initial.gas.temperature": 300.0,
                "initial.solids.beads.temperature": 300.0,
            },
            "velocities that change with time are for plug flow",
        ),
    ],
)
def test_what_is_refused(tmp_path, keys, message):
    refused(message, plan, scene(tmp_path, RING, **keys))


def test_a_cone_is_refused_before_its_run(tmp_path):
    """Flow along an oblique wall with slip is not solved around an axis."""
    cone = RING.replace("{0.05, 0, 0,", "{0.03, 0.04, 0,")
    cone = cone.replace("{0.2, 0, 0,", "{0.12, 0.16, 0,")
    around = scene(tmp_path, cone, **{"mesh.axisymmetric": True})
    refused("boundary.floor: a slip wall that the flow meets", plan, around)
