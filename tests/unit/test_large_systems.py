"""Systems of volumes that are too large for complete factors: multigrid, incomplete
factors, and what is refused.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from pytest import approx

import contbed as cb
from contbed.errors import ConvergenceError, SceneError
from contbed.loading import from_dict
from contbed.solvers import linear
from contbed.solvers.linear import Policy, Solver
from tests.balances import assert_closed
from tests.scene_text import scene_of


@pytest.fixture
def iterative(monkeypatch):
    """Every system counts as too large for factors; returns the list of (drop, fill)
    that were used.
    """
    used = []
    incomplete = linear._incomplete

    def counted(matrix, policy, drop, fill):
        used.append((drop, fill))
        return incomplete(matrix, policy, drop, fill)

    monkeypatch.setattr(linear, "DIRECT_3D", 0)
    monkeypatch.setattr(linear, "MULTIGRID_3D", 0)
    monkeypatch.setattr(linear, "FEW", 0)
    monkeypatch.setattr(linear, "_incomplete", counted)
    return used


@pytest.fixture
def iterations(monkeypatch):
    """Return the list of GMRES iterations of each solve."""
    counts = []
    gmres = linear._gmres

    def counted(*arguments, **options):
        steps = []
        found = gmres(
            *arguments, callback=steps.append, callback_type="pr_norm", **options
        )
        counts.append(len(steps))
        return found

    monkeypatch.setattr(linear, "_gmres", counted)
    return counts


def box(**tables):
    """A small volume with a hot floor."""
    found = scene_of(
        """
        [mesh]
        type = "box"
        length = 0.2
        width = 0.1
        height = 0.1
        [gas]
        density = 1.0
        heat_capacity = 1000.0
        conductivity = 0.1
        viscosity = 2e-5
        [solids.particles]
        density = 2000.0
        heat_capacity = 900.0
        conductivity = 5.0
        diameter = 0.01
        [packed_bed]
        porosity = 0.4
        [closures]
        nusselt = 1.0
        [heat]
        [boundary.left]
        gas.velocity = 0.05
        gas.temperature = 300.0
        [boundary.bottom]
        solids.particles.fixed_temperature = 500.0
        [output]
        plots = false
        fields = false
        """,
        {"mesh.cells": (6, 4, 4)},
    )
    return from_dict(found | tables)


HEAT = {
    "moving": scene_of("""
        [boundary]
        left.gas = { velocity = 0.05, temperature = 300.0 }
        right.solids.particles = { velocity = 1e-3, temperature = 700.0 }
        bottom.solids.particles = { fixed_temperature = 500.0 }
    """),
    "mixed": {"closures": {"nusselt": 1e4}, "heat": {}},
}


@pytest.mark.parametrize("shape", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("kind", ["rest", "moving", "mixed"])
def test_multigrid_gives_the_result_of_complete_factors(
    kind, degree, shape, iterative, iterations, monkeypatch
):
    """To the tolerance of GMRES, with two temperatures, at rest, moving, and bound
    by a strong exchange.
    """
    tables = HEAT.get(kind, {})
    mesh = {
        "type": "box",
        "length": 0.2,
        "width": 0.1,
        "height": 0.1,
        "cells": (6, 4, 4),
        "shape": shape,
    }
    scene = box(mesh=mesh, solver={"degree": degree}, **tables)
    cycled = cb.run(scene)
    assert iterations and not iterative
    assert max(iterations) <= (40 if shape == "hexahedron" else 70)
    monkeypatch.setattr(linear, "MULTIGRID_3D", 120_000)
    complete = cb.run(scene)
    for name in ("T_solid_out_K", "T_fluid_out_K"):
        assert cycled.qoi.get(name, 0.0) == approx(
            complete.qoi.get(name, 0.0), rel=1e-9
        )
    assert_closed(cycled, 1e-10, "energy")


def test_iterations_of_multigrid_do_not_grow_with_the_mesh(iterative, iterations):
    """Twice the cells in each direction: at most a quarter more, where one-level
    methods take twice as many.
    """
    for cells in ((6, 4, 4), (12, 8, 8)):
        cb.run(
            box(
                mesh={
                    "type": "box",
                    "length": 0.15,
                    "width": 0.1,
                    "height": 0.1,
                    "cells": cells,
                }
            )
        )
    assert iterations[-1] <= 1.25 * iterations[0] + 1


def test_incident_radiation_is_cycled_as_well(iterative, iterations, monkeypatch):
    """Three fields at a vertex; emission ties the third to the temperature of the
    solid.
    """
    solid = {
        "density": 2000.0,
        "heat_capacity": 900.0,
        "conductivity": 5.0,
        "diameter": 0.01,
        "emissivity": 0.8,
    }
    scene = box(radiation={"level": "p1"}, solids={"particles": solid})
    cycled = cb.run(scene)
    assert iterations and not iterative
    monkeypatch.setattr(linear, "MULTIGRID_3D", 120_000)
    assert cycled.qoi["heat_bottom_W"] == approx(
        cb.run(scene).qoi["heat_bottom_W"], rel=1e-8
    )


def test_thin_factors_take_over_where_multigrid_does_not_do(iterative, monkeypatch):
    """To the tolerance of GMRES; the balance closes as it does with complete
    factors.
    """
    monkeypatch.setattr(
        linear, "two_level", lambda matrix, vertices: lambda rhs: rhs[::-1].copy()
    )
    thin = cb.run(box())
    assert set(iterative) == {linear.THIN}
    monkeypatch.setattr(linear, "FEW", 120_000)
    factored = cb.run(box())
    monkeypatch.setattr(linear, "MULTIGRID_3D", 120_000)
    complete = cb.run(box())
    for name in ("heat_bottom_W", "T_fluid_out_K"):
        assert thin.qoi[name] == approx(complete.qoi[name], rel=1e-9)
        assert factored.qoi[name] == approx(complete.qoi[name], rel=1e-9)


def test_pressures_get_thick_factors(iterative):
    """A saddle point has no diagonal to keep."""
    matrix = sp.csc_matrix([[2.0, 0.0, 1.0], [0.0, 3.0, 1.0], [1.0, 1.0, 0.0]])
    rhs = np.array([1.0, 2.0, 3.0])
    assert matrix @ Solver(matrix, Policy(3))(rhs) == approx(rhs, rel=1e-9)
    assert iterative == [linear.THICK]


def test_thick_factors_that_do_not_fit_are_refused(iterative):
    """With the bytes needed and allowed, and a remedy."""
    matrix = sp.csc_matrix([[2.0, 0.0, 1.0], [0.0, 3.0, 1.0], [1.0, 1.0, 0.0]])
    policy = Policy(3, 1e-4)
    policy.limit_GB = 1e-7
    with pytest.raises(ConvergenceError, match="GB allowed; coarsen the mesh"):
        linear._incomplete(matrix, policy, *linear.THICK)


def test_memory_is_refused_before_assembly(monkeypatch):
    """A box of 20 x 10 x 10 cells needs 0.4 GB: said with the numbers before
    anything is assembled.
    """
    from contbed.packed_bed.heat import HeatProblem

    monkeypatch.setattr(HeatProblem, "__init__", lambda *_: pytest.fail("assembled"))
    with pytest.raises(
        SceneError,
        match=r"unknowns need about .* GB, allowed are 0.2 GB; coarsen the mesh",
    ):
        cb.run(box(mesh={"type": "box", "length": 0.2, "width": 0.1, "height": 0.1, "cells": (20, 10, 10)},
                   solver={"memory_GB": 0.2}))  # fmt: skip


def test_predicted_memory_of_a_volume():
    """As measured: 2.2 GB for the factors of 68,000 unknowns, 10 kB for each with
    multigrid; within 5 %.
    """
    assert Policy(3, None).predicted_GB(68_000) == approx(2.2, rel=0.05)
    assert Policy(3, None, multigrid=True).predicted_GB(68_000) == approx(
        0.68, rel=0.05
    )


def test_predicted_memory_of_a_line_in_blocks():
    """Two copies of three blocks of 3072^2 for each of 24 cells, 10.9 GB; 10.7 GB
    measured.
    """
    found = Policy(1, block=3072).predicted_GB(24 * 3072)
    assert found == approx(1e-9 * 8 * 2 * 3 * 24 * 3072**2, rel=1e-12)


def test_an_automatic_box_is_small_and_has_an_estimate():
    """The plan holds a first mesh of at most 2000 cells and says how many there may
    be.
    """
    plan = cb.plan(
        box(mesh={"type": "box", "length": 0.2, "width": 0.1, "height": 0.1})
    )
    assert plan.mesh.skfem.nelements <= 2000
    assert "4000 cells at most" in str(plan)
    assert cb.run(box()).qoi["estimated_error"] > 1e-3
