"""Systems of volumes that are too large for complete factors: thin and thick incomplete ones, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

import contbed as cb
from contbed.errors import ConvergenceError, SceneError
from contbed.loading import from_dict
from contbed.solvers import linear
from contbed.solvers.linear import Policy, Solver


@pytest.fixture
def iterative(monkeypatch):
    """Every system counts as too large for factors; returns the list of (drop, fill) that were used."""
    used = []
    incomplete = linear._incomplete

    def counted(matrix, policy, drop, fill):
        used.append((drop, fill))
        return incomplete(matrix, policy, drop, fill)

    monkeypatch.setattr(linear, "DIRECT_3D", 0)
    monkeypatch.setattr(linear, "_incomplete", counted)
    return used


def box(**tables):
    """A small volume with a hot floor."""
    found = {
        "mesh": {"type": "box", "length": 0.2, "width": 0.1, "height": 0.1, "cells": (6, 4, 4)},
        "fluid": {"density": 1.0, "heat_capacity": 1000.0, "conductivity": 0.1, "viscosity": 2e-5},
        "solid": {"density": 2000.0, "heat_capacity": 900.0, "conductivity": 5.0},
        "bed": {"porosity": 0.4, "particle_diameter": 0.01},
        "flow": {"velocity": 0.05},
        "heat": {"nusselt": 1.0},
        "boundary": {"left": {"fluid": {"inflow": 300.0}}, "bottom": {"solid": {"fixed": 500.0}}},
        "output": {"plots": False, "fields": False},
    }
    return from_dict(found | tables)


def test_thin_factors_give_the_result_of_complete_ones(iterative, monkeypatch):
    """To the tolerance of GMRES; the balance closes as it does with complete factors."""
    thin = cb.run(box())
    assert set(iterative) == {linear.THIN}
    monkeypatch.setattr(linear, "DIRECT_3D", 120_000)
    complete = cb.run(box())
    for name in ("heat_bottom_W", "T_fluid_out_K"):
        assert thin.qoi[name] == pytest.approx(complete.qoi[name], rel=1e-9)


def test_pressures_get_thick_factors(iterative):
    """A saddle point has no diagonal to keep."""
    matrix = sp.csc_matrix([[2.0, 0.0, 1.0], [0.0, 3.0, 1.0], [1.0, 1.0, 0.0]])
    rhs = np.array([1.0, 2.0, 3.0])
    assert matrix @ Solver(matrix, Policy(3))(rhs) == pytest.approx(rhs, rel=1e-9)
    assert iterative == [linear.THICK]


def test_thick_factors_that_do_not_fit_are_refused(iterative):
    """With the bytes needed and allowed, and a remedy."""
    matrix = sp.csc_matrix([[2.0, 0.0, 1.0], [0.0, 3.0, 1.0], [1.0, 1.0, 0.0]])
    policy = Policy(3, 1e-4)
    policy.limit_GB = 1e-7
    with pytest.raises(ConvergenceError, match="GB allowed; coarsen the mesh"):
        linear._incomplete(matrix, policy, *linear.THICK)


def test_memory_is_refused_before_assembly(monkeypatch):
    """A box of 20 x 10 x 10 cells needs 0.6 GB: said with the numbers before anything is assembled."""
    from contbed.packed_bed.heat import HeatProblem

    monkeypatch.setattr(HeatProblem, "__init__", lambda *_: pytest.fail("assembled"))
    with pytest.raises(SceneError, match=r"unknowns need about .* GB, allowed are 0.4 GB; coarsen the mesh"):
        cb.run(box(mesh={"type": "box", "length": 0.2, "width": 0.1, "height": 0.1, "cells": (20, 10, 10)},
                   solver={"memory_GB": 0.4}))  # fmt: skip


def test_an_automatic_box_is_small_and_has_an_estimate():
    """The plan holds a first mesh of at most 2000 cells and says how many there may be."""
    plan = cb.plan(box(mesh={"type": "box", "length": 0.2, "width": 0.1, "height": 0.1}))
    assert plan.mesh.skfem.nelements <= 2000
    assert "4000 cells at most" in str(plan)
    assert cb.run(box()).qoi["estimated_error"] > 1e-3
