"""Heat is conserved and space has no preferred direction, whatever a scene combines.

A balance closes to 1e-10 of its largest part: sums are exact by construction, so what
is left is round-off, and 1e-10 leaves four digits for the size of the systems. Runs
raise BalanceError beyond it; here the number is checked as well. Symmetric scenes are
compared to 1e-9 K, the accuracy of the linear solves times the temperatures.
"""

from typing import Any

import numpy as np
import pytest
from moving_beds import moving, started
from numpy.testing import assert_allclose

import contbed as cb
from contbed.fem.probe import Probe
from contbed.loading import from_dict
from studies._exact.finite_length import finite_length
from tests.balances import assert_closed
from tests.scene_text import scene_of

CLOSED, EQUAL = 1e-10, 1e-9

FLUID = {
    "density": 1.2,
    "heat_capacity": 1000.0,
    "conductivity": 0.05,
    "viscosity": 2e-5,
}
SOLID = {"density": 2000.0, "heat_capacity": 900.0, "conductivity": 2.0}
WARM = {"density": 2000.0, "heat_capacity": [600.0, 0.6], "conductivity": [1.0, 2e-3]}
MESHES: dict[str, dict[str, Any]] = scene_of("""
    line = { type = "line", length = 1.0, cells = 12 }
    rectangle = { type = "rectangle", length = 1.0, height = 0.4, cells = [8, 4] }
    triangles = { type = "rectangle", length = 1.0, height = 0.4, cells = [8, 4], shape = "triangle" }
    axisymmetric = { type = "axisymmetric", length = 1.0, radius = 0.3, cells = [4, 8] }
    box = { type = "box", length = 1.0, width = 0.4, height = 0.3, cells = [4, 2, 2] }

    [tetrahedra]
    type = "box"
    length = 1.0
    width = 0.4
    height = 0.3
    cells = [3, 2, 2]
    shape = "tetrahedron"
""")
FIXED = {"fixed_temperature": 400.0}
INFLOW = {"temperature": 400.0}
FLUX = {"heat_flux": 500.0}
ROBIN = {"coefficient": 20.0, "ambient": 350.0}


def ends(mesh: str) -> tuple[str, str]:
    return ("bottom", "top") if mesh == "axisymmetric" else ("left", "right")


def walls(mesh: str) -> list[str]:
    return {"line": [], "axisymmetric": ["wall"]}.get(mesh, ["bottom", "top"])


def scene(
    mesh: str = "line",
    *,
    velocity: Any = 0.2,
    velocity_solid: Any = 1e-4,
    inlet: Any = INFLOW,
    wall: Any = None,
    solid: Any = SOLID,
    boundary: Any = None,
    **tables: Any,
) -> dict[str, Any]:
    """Fluid enters at 300 K at the low end, solid as `inlet` says at its own end,
    `wall` acts on the solid.
    """
    low, high = ends(mesh)
    own_end = high if np.sum(velocity_solid) < 0 else low
    if boundary is None:
        boundary = {low: {"gas": {"temperature": 300.0}}}
        boundary.setdefault(own_end, {})["solids"] = {"particles": inlet}
        for name in walls(mesh):
            if wall is not None:
                boundary[name] = {"solids": {"particles": wall}}
    return (
        scene_of(
            """
                packed_bed = { porosity = 0.4 }
                closures = { nusselt = 5.0 }
                heat = {}
            """,
            {
                "mesh": MESHES[mesh],
                "gas": FLUID,
                "solids.particles": {**solid, "diameter": 0.02},
                "boundary": moving(MESHES[mesh], boundary, velocity, velocity_solid),
            },
        )
        | tables
    )


def run(values: dict[str, Any]) -> Any:
    return cb.run(from_dict(values))


def closed(result: Any) -> Any:
    assert_closed(result, CLOSED)
    assert result.balances["energy"]["in"] > 0
    return result


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("wall", [FIXED, FLUX, ROBIN], ids=["fixed", "flux", "robin"])
def test_walls_on_every_mesh(mesh, wall):
    closed(run(scene(mesh, wall=wall)))


@pytest.mark.parametrize(
    "velocity_solid",
    [1e-4, 0.0, -1e-4],
    ids=["co-current", "at rest", "counter-current"],
)
@pytest.mark.parametrize(
    "inlet", [FIXED, INFLOW, FLUX, ROBIN], ids=["fixed", "inflow", "flux", "robin"]
)
@pytest.mark.parametrize("solid", [SOLID, WARM], ids=["constant", "variable"])
def test_inlets(velocity_solid, inlet, solid):
    if velocity_solid == 0.0 and "temperature" in inlet:
        pytest.skip("nothing enters at rest")
    values = scene(velocity_solid=velocity_solid, inlet=inlet, solid=solid)
    if velocity_solid != 0.0 and not {"fixed_temperature", "temperature"} & set(inlet):
        # the entering stream needs a temperature; the condition acts at the other end
        low, high = ends("line")
        entry, exit_ = (low, high) if velocity_solid > 0 else (high, low)
        moves = {"velocity": abs(velocity_solid)}
        values["boundary"].setdefault(entry, {})["solids"] = {
            "particles": INFLOW | moves
        }
        values["boundary"].setdefault(exit_, {})["solids"] = {"particles": inlet}
    closed(run(values))


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("stabilisation", [True, False])
@pytest.mark.parametrize("mesh", ["line", "triangles", "axisymmetric", "tetrahedra"])
def test_degrees_and_stabilisation(mesh, degree, stabilisation):
    solver = {"degree": degree, "stabilisation": stabilisation}
    closed(run(scene(mesh, wall=ROBIN, velocity_solid=-1e-4, solver=solver)))


@pytest.mark.parametrize("solid", [SOLID, WARM], ids=["constant", "variable"])
@pytest.mark.parametrize("mesh", ["line", "rectangle", "axisymmetric", "box"])
def test_transients(mesh, solid):
    time = {"end": 2000.0, "step": 400.0}
    values = scene(
        mesh,
        wall=ROBIN,
        solid=solid,
        inlet=FIXED,
        time=time,
        initial=started(320.0, 350.0),
    )
    result = closed(run(values))
    assert (
        abs(result.balances["energy"]["stored"])
        > 1e-3 * result.balances["energy"]["in"]
    )


@pytest.mark.parametrize("time", [None, {"end": 500.0}])
def test_sources_by_region(time):
    values = scene(
        "rectangle",
        wall=ROBIN,
        region={
            "bed": {"gas": {"heat_source": 100.0}, "solids": {"heat_source": 2000.0}}
        },
    )
    if time is not None:
        values |= {"time": time, "initial": started(300.0, 300.0)}
    result = closed(run(values))
    # power density times area 0.4 m2 (per metre of depth), times the duration of a
    # transient
    expected = 2100.0 * 0.4 * (500.0 if time else 1.0)
    assert result.balances["energy"]["source"] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("solid", [SOLID, WARM], ids=["constant", "variable"])
@pytest.mark.parametrize("stabilisation", [True, False])
def test_cross_current(solid, stabilisation):
    """The solid moves along y."""
    boundary = {
        "left": {"gas": {"temperature": 300.0}},
        "bottom": {"solids": {"particles": {"temperature": 400.0}}},
        "top": {},
        "right": {},
    }
    result = closed(
        run(
            scene(
                "rectangle",
                velocity=[0.2, 0.0],
                velocity_solid=[0.0, 1e-4],
                boundary=boundary,
                solid=solid,
                solver={"stabilisation": stabilisation},
            )
        )
    )
    assert (
        300.0 < result.qoi["T_solid_out_K"] < 400.0
        and 300.0 < result.qoi["T_fluid_out_K"] < 400.0
    )


def brinkman(
    mesh: str, T: tuple[float, float, float], degree: int = 2, **tables: Any
) -> dict[str, Any]:
    """Computed flow: walls without slip; temperatures of fluid, solid and walls."""
    low, _ = ends(mesh)
    boundary = {
        low: {
            "gas": {"temperature": T[0]},
            "solids": {"particles": {"temperature": T[1]}},
        }
    }
    for name in walls(mesh):
        boundary[name] = {
            "type": "no_slip",
            "solids": {"particles": {"fixed_temperature": T[2]}},
        }
    return scene(mesh, boundary=boundary, solver={"degree": degree}, **tables)


@pytest.mark.parametrize("mesh", ["rectangle", "triangles", "axisymmetric"])
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_computed_flow_conserves_and_keeps_a_uniform_temperature(mesh, degree):
    closed(run(brinkman(mesh, (300.0, 400.0, 350.0), degree)))
    still = run(brinkman(mesh, (350.0, 350.0, 350.0), degree))
    for name in ("T_fluid [K]", "T_solid [K]"):
        assert_allclose(still.profiles[name], 350.0, rtol=0, atol=EQUAL)
    for name in ("T_fluid", "T_solid"):
        assert_allclose(still.nodal[name][1], 350.0, rtol=0, atol=EQUAL)


def test_computed_flow_with_variable_properties_and_time():
    closed(run(brinkman("triangles", (300.0, 400.0, 350.0), solid=WARM)))
    time = {"end": 500.0, "step": 100.0}
    start = started(300.0, 300.0)
    closed(
        run(
            brinkman(
                "triangles", (300.0, 400.0, 350.0), solid=WARM, time=time, initial=start
            )
        )
    )


def values_at(result: Any, points: np.ndarray) -> np.ndarray:
    """Both temperatures at points (dim, n)."""
    probe = Probe(result.plan.mesh, points)
    return np.array([probe(*result.nodal[name]) for name in ("T_fluid", "T_solid")])


@pytest.mark.parametrize("solid", [SOLID, WARM], ids=["constant", "variable"])
def test_mirrored_line(solid):
    x = np.linspace(0.0, 1.0, 37)
    right = run(scene(inlet=FIXED, solid=solid))
    mirrored = {
        "right": {"gas": {"temperature": 300.0}, "solids": {"particles": FIXED}}
    }
    left = run(
        scene(velocity=-0.2, velocity_solid=-1e-4, boundary=mirrored, solid=solid)
    )
    assert_allclose(
        values_at(right, x[None]), values_at(left, 1.0 - x[None]), rtol=0, atol=EQUAL
    )


def test_mirrored_channel_with_computed_flow():
    """Left to right, and the upper half as the lower one."""
    points = np.random.default_rng(1).uniform((0.01, 0.01), (0.99, 0.39), (50, 2)).T
    there = run(brinkman("rectangle", (300.0, 400.0, 350.0)))
    values = brinkman("rectangle", (300.0, 400.0, 350.0))
    values["boundary"]["right"] = values["boundary"].pop("left")
    back = run(values)
    reference = values_at(there, points)
    turned = np.array([[1.0], [0.0]]) + np.array([[-1.0], [1.0]]) * points
    assert_allclose(values_at(back, turned), reference, rtol=0, atol=EQUAL)
    upside = np.array([[0.0], [0.4]]) + np.array([[1.0], [-1.0]]) * points
    assert_allclose(values_at(there, upside), reference, rtol=0, atol=EQUAL)


SIDES = (("left", "right"), ("front", "back"), ("bottom", "top"))


def test_one_dimension_stands_for_two_and_three():
    """A line, and the same bed solved in full: profiles, and heat that scales with the
    cross-section.

    Without stabilisation, whose cell size is the longest edge, and so depends on the
    cells across.
    """
    x = np.linspace(0.0, 1.0, 29)
    line = run(scene("line", inlet=FIXED, solver={"stabilisation": False}))
    reference, entering = values_at(line, x[None]), line.balances["energy"]["in"]
    for mesh, section in (
        ("rectangle", 0.4),
        ("axisymmetric", np.pi * 0.09),
        ("box", 0.12),
    ):
        cells = (
            [2, 12]
            if mesh == "axisymmetric"
            else [12, *[2] * (len(MESHES[mesh]["cells"]) - 1)]
        )
        for reduce in (True, False):
            values = scene(
                mesh, inlet=FIXED, solver={"reduce": reduce, "stabilisation": False}
            )
            result = closed(run({**values, "mesh": {**MESHES[mesh], "cells": cells}}))
            assert result.plan.mesh.skfem.dim() == (1 if reduce else len(cells))
            across = [np.full_like(x, 0.1)] * (result.plan.mesh.skfem.dim() - 1)
            at = np.array([*across, x] if mesh == "axisymmetric" else [x, *across])
            assert_allclose(values_at(result, at), reference, rtol=0, atol=EQUAL)
            assert result.balances["energy"]["in"] == pytest.approx(
                section * entering, rel=1e-9
            )


def test_turned_plane():
    """Streams at an angle to the mesh of a square: turned by 90 degrees, the same
    field.
    """
    points = np.random.default_rng(3).uniform(0.02, 0.98, (2, 60))
    square = {"type": "rectangle", "length": 1.0, "height": 1.0, "cells": [6, 6]}

    def solved(velocity: list[float], inlets: list[str]) -> Any:
        boundary = {
            name: {"gas": {"temperature": 300.0}, "solids": {"particles": FIXED}}
            for name in inlets
        }
        values = scene(
            "rectangle",
            velocity=velocity,
            velocity_solid=[1e-3 * v for v in velocity],
            boundary=boundary,
        )
        return run({**values, "mesh": square})

    one = solved([0.2, 0.1], ["left", "bottom"])
    other = solved([-0.1, 0.2], ["bottom", "right"])
    turned = np.array([1.0 - points[1], points[0]])
    assert_allclose(
        values_at(other, turned), values_at(one, points), rtol=0, atol=EQUAL
    )


@pytest.mark.parametrize("inlet", ["fixed_temperature", "temperature"])
def test_inlets_against_the_exact_solution(inlet):
    """A fixed and a Danckwerts inlet of the solid.

    C s(0-) = C s(0+) - K s'(0) defines the temperature at the inlet; with it as the
    fixed value the exact solution of a finite bed must be met, to 1e-6 of the span on
    200 quadratic cells.
    """
    values = scene(inlet={inlet: 400.0}, velocity_solid=1e-3)
    values["mesh"] = {"type": "line", "length": 1.0, "cells": 200, "graded": True}
    values["boundary"]["left"]["gas"] = {"velocity": 0.2, "fixed_temperature": 300.0}
    result = closed(run(values))
    x, s = result.profiles["x [m]"], result.profiles["T_solid [K]"]
    area = 6.0 * 0.6 / 0.02
    c = {
        "flux_fluid": 1.2 * 1000.0 * 0.2,
        "flux_solid": 2000.0 * 900.0 * 1e-3,
        "d_fluid": 0.4 * 0.05,
        "d_solid": 0.6 * 2.0,
        "ha": 5.0 * 0.05 / 0.02 * area,
    }
    if inlet == "fixed_temperature":
        entry = 400.0
    else:
        slope = finite_length(0.0, 1.0, **c, derivative=1)[1]
        entry = 300.0 + 100.0 / (1.0 - float(slope) * c["d_solid"] / c["flux_solid"])
    f_exact, s_exact = (300.0 + (entry - 300.0) * v for v in finite_length(x, 1.0, **c))
    assert_allclose(s, s_exact, rtol=0, atol=1e-4)
    assert_allclose(result.profiles["T_fluid [K]"], f_exact, rtol=0, atol=1e-4)
    assert inlet == "fixed_temperature" or entry < 399.95
