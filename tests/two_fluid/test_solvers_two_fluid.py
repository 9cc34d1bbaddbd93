"""The solvers of the two-fluid step against dense matrices."""

import numpy as np
import pytest
from core_closures import line, rectangle

from contbed.two_fluid.fv import grid as grid_lists
from contbed.two_fluid.linear import cg
from contbed.two_fluid.linear.cg import System
from contbed.two_fluid.linear.elimination import Elimination
from contbed.two_fluid.linear.lattice import build_levels
from contbed.two_fluid.linear.lattice_multigrid import LatticeMultigrid, solve_exchange


@pytest.fixture(autouse=True)
def small_grids_in_rows(monkeypatch):
    """Kernels over rows on grids of any size."""
    monkeypatch.setattr(grid_lists, "FEWEST_IN_ROWS", 0)


GRIDS = {
    "quadrilaterals": lambda: rectangle(0.1, 0.2, (7, 12)),
    "triangles": lambda: rectangle(0.1, 0.2, (5, 9), shape="triangle"),
    "wide": lambda: rectangle(0.2, 0.2, (40, 41)),
    "periodic": lambda: rectangle(0.1, 0.2, (2, 12), [("left", "right")]),
    "line": lambda: line(0.1, 9, True),
}


def matrix(grid, coef, diagonal):
    """Dense matrix of diagonal x + sum of coef (x - x_neighbour)."""
    g, ni = grid.geometry, grid.interior
    out = np.diag(diagonal)
    np.add.at(out, (g.left, g.left), coef)
    np.add.at(out, (g.right, g.right), coef[:ni])
    np.add.at(out, (g.left[:ni], g.right), -coef[:ni])
    np.add.at(out, (g.right, g.left[:ni]), -coef[:ni])
    return out


@pytest.mark.parametrize("name", GRIDS)
@pytest.mark.parametrize("floating", [False, True])
def test_elimination(name, floating):
    grid, rng = GRIDS[name](), np.random.default_rng(1)
    count, ni = len(grid.cells), grid.interior
    coef = 10.0 ** rng.uniform(-2, 1, len(grid.geometry.left))
    floating = floating or len(coef) == ni
    coef[ni:] *= not floating
    dense = matrix(grid, coef, np.zeros(count))
    dense[0, 0] *= 1.0 + floating
    x = rng.normal(size=count)
    expected = np.linalg.solve(dense, x)
    assert Elimination(grid).solve(grid.geometry, coef, floating, x)
    # rounding times the condition of the matrix, about 1e5
    np.testing.assert_allclose(x, expected, atol=1e-9 * np.abs(expected).max())


def test_elimination_refuses_a_matrix_that_is_not_positive():
    grid = rectangle(0.1, 0.2, (4, 5))
    coef = np.where(np.arange(len(grid.geometry.left)) < grid.interior, -1.0, 0.0)
    assert not Elimination(grid).solve(grid.geometry, coef, False, np.ones(20))


def on_lattice(grid):
    """Solution on the lattice of the grid, with the arguments of cg.solve."""
    levels = build_levels(grid)
    if levels is None:
        pytest.skip("no lattice")

    def solve(g, system, explicit, tolerance, most, x):
        found = np.ascontiguousarray(x.T)
        by_component = System(*(np.ascontiguousarray(part.T) for part in system))
        lattice = LatticeMultigrid(grid, levels)
        iterations = solve_exchange(
            lattice, by_component, explicit, tolerance, most, found
        )
        x[:], system.links[:] = found.T, by_component.links.T
        return iterations

    return solve


@pytest.mark.parametrize("lattice", [False, True], ids=["any mesh", "lattice"])
@pytest.mark.parametrize("name", GRIDS)
def test_implicit_exchange(name, lattice):
    """All cells against a dense matrix; the stiff ones alone keep the sum and leave
    the quiet ones explicit.
    """
    grid, rng = GRIDS[name](), np.random.default_rng(2)
    count, ni = len(grid.cells), grid.interior
    g = grid.geometry
    coef = 10.0 ** rng.uniform(-4, 2, (len(g.left), 2)) * (
        grid.middles[:, :1] > grid.centres[:, 0].mean()
    )
    content, rhs = rng.uniform(1, 2, (count, 2)), rng.normal(size=(count, 2))
    x = np.empty_like(rhs)
    solve = on_lattice(grid) if lattice else cg.solve
    assert (
        solve(g, System(coef, np.zeros_like(x), content, rhs), 0.0, 1e-12, 500, x) > 0
    )
    for k in range(2):
        np.testing.assert_allclose(
            x[:, k],
            np.linalg.solve(matrix(grid, coef[:, k], content[:, k]), rhs[:, k]),
            atol=1e-9,
        )

    coef[ni:] = 0.0
    links = np.zeros_like(x)
    solve(g, System(coef, links, content, rhs), 0.1, 1e-12, 500, x)
    np.testing.assert_allclose((content * x).sum(axis=0), rhs.sum(axis=0), atol=1e-9)
    stiff = (links > 0.1 * content).any(axis=1)
    beside = np.zeros(count, dtype=bool)
    beside[g.left[:ni][stiff[g.right]]] = beside[g.right[stiff[g.left[:ni]]]] = True
    quiet = ~(stiff | beside)
    np.testing.assert_array_equal(x[quiet], (rhs / content)[quiet])
    assert stiff.any()
