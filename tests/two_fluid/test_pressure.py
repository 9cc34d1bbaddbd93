"""The equation of pressure: elimination and multigrid agree, iterations do not grow,
the flux has no divergence.
"""

import numpy as np
import pytest
from core_closures import rectangle
from gmsh_meshes import unstructured
from numpy.testing import assert_allclose
from test_core_exact import WALLS, fluidized

from contbed.errors import ConvergenceError
from contbed.mesh import build as meshing
from contbed.scene.mesh import MeshBox
from contbed.two_fluid.fv import grid
from contbed.two_fluid.linear import pressure_solver
from contbed.two_fluid.linear.elimination import Elimination
from contbed.two_fluid.linear.lattice import build_levels
from contbed.two_fluid.linear.lattice_multigrid import LatticeMultigrid
from contbed.two_fluid.linear.pressure_solver import multigrid_on


def system(on, seed=1):
    """Coefficients with a jump of 1000 between the halves, as at the surface of a
    bed, outlet at the top; fluxes in.
    """
    g, random = on.geometry, np.random.default_rng(seed)
    low = on.middles[:, -1] < 0.5 * on.middles[:, -1].max()
    coef = (
        g.area
        / g.distance
        * random.uniform(0.5, 2.0, len(g.left))
        * np.where(low, 1e-3, 1.0)
    )
    top = on.boundaries.get("top", np.empty(0, dtype=int))
    closed = np.setdiff1d(np.arange(on.interior, len(g.left)), top)
    coef[closed] = 0.0
    return coef, g.volume * random.standard_normal(len(g.volume))


def box(cells):
    """Grid of a box."""
    mesh = MeshBox(type="box", length=0.1, width=0.2, height=0.3, cells=cells)
    return grid.build(meshing.build(mesh))


GRIDS = [
    lambda: rectangle(0.28, 1.0, (14, 50)),
    lambda: rectangle(0.28, 2.0, (13, 51)),
    pytest.param(lambda: box((5, 7, 12)), marks=pytest.mark.slow),
    lambda: rectangle(0.28, 1.0, (14, 50), [("left", "right")]),
    lambda: rectangle(0.28, 1.0, (14, 50), [("left", "right"), ("bottom", "top")]),
    lambda: unstructured("triangles", 0.06, 0.12, 0.006),
    lambda: unstructured("tetrahedra", 0.06, 0.12, 0.015),
]


def of_lattice(on):
    """Multigrid on the lattice, where the grid has one."""
    levels = build_levels(on)
    if levels is None:
        pytest.skip("no lattice")
    return LatticeMultigrid(on, levels)


@pytest.mark.parametrize("make", GRIDS)
@pytest.mark.parametrize("multigrid", [multigrid_on, of_lattice])
@pytest.mark.parametrize("floating", [False, True])
def test_multigrid_agrees_with_elimination(make, multigrid, floating):
    on = make()
    coef, rhs = system(on)
    floating = floating or len(coef) == on.interior
    if floating:
        coef[on.interior :] = 0.0
        rhs -= rhs.mean()
    exact = rhs.copy()
    assert Elimination(on).solve(on.geometry, coef, floating, exact)
    found = np.zeros_like(rhs)
    assert 0 < multigrid(on).solve(coef, floating, rhs, found) < 40
    # residuals of 1e-11 times the condition of the system
    assert_allclose(found, exact, atol=1e-7 * np.ptp(exact))


@pytest.mark.parametrize("multigrid", [multigrid_on, of_lattice])
def test_iterations_hardly_grow(multigrid):
    counts = []
    for cells in ((7, 25), (28, 100), (56, 200)):
        on = rectangle(0.28, 1.0, cells)
        coef, rhs = system(on)
        counts.append(multigrid(on).solve(coef, False, rhs, np.zeros_like(rhs)))
    assert counts[2] < 40 and counts[2] < 1.5 * counts[0], counts


@pytest.mark.parametrize("multigrid", [multigrid_on, of_lattice])
def test_exact_guess_needs_no_iteration(multigrid):
    on = rectangle(0.28, 1.0, (14, 50))
    coef, rhs = system(on)
    p = np.zeros_like(rhs)
    by = multigrid(on)
    assert by.solve(coef, False, rhs, p) > 5
    assert by.solve(coef, False, rhs, p) == 0
    assert by.solve(coef, False, 0 * rhs, np.zeros_like(rhs)) == 0


def test_bed_by_multigrid(monkeypatch):
    """The same bed with either solver; the flux of both phases has no divergence to
    1e-10, a restart gives the same.
    """
    one = fluidized(WALLS[2], noise=0.01)
    monkeypatch.setattr(pressure_solver, "WIDEST_BAND_OF_LATTICE", 0)
    two = fluidized(WALLS[2], noise=0.01)
    for _ in range(30):
        one.step(one.next_step())
        two.step(two.next_step())
    assert two.model.pressure_solver.iterations > 0
    assert_allclose(two.state.eps_s, one.state.eps_s, atol=1e-8)
    assert_allclose(two.state.p, one.state.p, atol=1e-5)
    g = two.model.grid.geometry
    left = np.zeros(len(two.state.p))
    np.add.at(left, g.left, two.state.fluxes.total)
    np.subtract.at(left, g.right, two.state.fluxes.total[: two.model.grid.interior])
    assert np.abs(left).max() < 1e-10 * np.abs(two.state.fluxes.total).max()
    saved = two.saved()
    two.step(1e-4)
    three = fluidized(WALLS[2])
    three.restore(saved)
    three.step(1e-4)
    assert np.array_equal(two.state.p, three.state.p)


def test_pressure_that_cannot_be_found(monkeypatch):
    monkeypatch.setattr(pressure_solver, "WIDEST_BAND_OF_LATTICE", 0)
    on = rectangle(0.28, 1.0, (14, 50))
    coef, rhs = system(on)
    coef[3] = np.nan
    with pytest.raises(ConvergenceError, match="did not converge"):
        pressure_solver.PressureSolver(on, False).solve(coef, rhs, np.zeros_like(rhs))
