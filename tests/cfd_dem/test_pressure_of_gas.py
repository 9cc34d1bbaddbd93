"""Pressure equation of the gas: the solution of a dense solver, and iterations that
do not grow with the grid.
"""

import numpy as np
import pytest

from contbed.cfd_dem.grid import OUTLET, Grid
from contbed.cfd_dem.pressure import Pressure
from contbed.solvers.aggregation import COARSEST

TOLERANCE = 1e-12


def equation(count, periodic, spread, blocked=None):
    """Grid, conductances of the faces over `spread` decades, and right-hand side."""
    rng = np.random.default_rng(1)
    grid = Grid(np.zeros(3), np.array([1.0, 1.2, 0.8]), count, periodic, blocked)
    conductance = np.where(
        grid.active, 10.0 ** rng.uniform(-spread / 2, spread / 2, len(grid.active)), 0.0
    )
    source = np.where(grid.open_cells, rng.normal(size=grid.cells), 0.0)
    return grid, conductance, source


def dense(grid, conductance, source):
    """Solve the same equation as a full matrix, built face by face."""
    matrix = np.zeros((grid.cells, grid.cells))
    for face, (low, high) in enumerate(grid.face_cell):
        if conductance[face] == 0.0 or low == high:
            continue
        for cell, beyond in ((low, high), (high, low)):
            if cell >= 0:
                matrix[cell, cell] += conductance[face]
                if beyond >= 0:
                    matrix[cell, beyond] -= conductance[face]
    alone = np.diag(matrix) == 0.0
    matrix[alone, alone] = 1.0
    return np.linalg.solve(matrix, source)


@pytest.mark.parametrize("periodic", [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("count", [(1, 1, 6), (2, 2, 5), (5, 3, 7), (6, 1, 4)])
def test_solution_of_a_dense_solver(count, periodic):
    grid, conductance, source = equation(count, periodic, spread=4)
    p, iterations = Pressure(grid).solve(
        np.zeros(grid.cells), conductance, source, TOLERANCE
    )
    assert iterations >= 0
    wanted = dense(grid, conductance, source)
    # the residual times the condition of the matrix, below 1e4 times the 4 decades
    assert p == pytest.approx(wanted, abs=1e-7 * np.abs(wanted).max())


def test_cells_that_hold_no_gas_are_left_out():
    blocked = np.zeros((5, 4, 6), bool)
    blocked[1:3, 1:3, 2:4] = True
    grid, conductance, source = equation(blocked.shape, (False, False), 2, blocked)
    assert (grid.face_kind == OUTLET).any()
    p, _ = Pressure(grid).solve(np.zeros(grid.cells), conductance, source, TOLERANCE)
    wanted = dense(grid, conductance, source)
    assert p == pytest.approx(wanted, abs=1e-8 * np.abs(wanted).max())
    assert (p[blocked.ravel()] == 0.0).all()


def test_many_cells_that_hold_no_gas_end_the_levels():
    """More cells without links than the coarsest level has: they are one group there,
    or levels would have no end.
    """
    blocked = np.zeros((7, 6, 8), bool)
    blocked[1:6, 1:5, 1:7] = True
    assert blocked.sum() > COARSEST
    grid, conductance, source = equation(blocked.shape, (False, False), 2, blocked)
    p, iterations = Pressure(grid).solve(
        np.zeros(grid.cells), conductance, source, TOLERANCE
    )
    wanted = dense(grid, conductance, source)
    assert 0 <= iterations < 40
    assert p == pytest.approx(wanted, abs=1e-8 * np.abs(wanted).max())


def test_a_good_guess_takes_no_iteration():
    grid, conductance, source = equation((5, 3, 7), (False, False), 2)
    p, _ = Pressure(grid).solve(np.zeros(grid.cells), conductance, source, TOLERANCE)
    again, iterations = Pressure(grid).solve(p, conductance, source, 1e-11)
    assert iterations == 0
    assert np.array_equal(again, p)


@pytest.mark.parametrize("sides", [8, 16, 32])
def test_iterations_do_not_grow_with_the_bed(sides):
    # columns alone as preconditioner take 126, 174 and 235; a bed below a freeboard:
    # the drag of the bed resists ten times as much as the gas alone; 8 iterations, two
    # more are room for other random numbers
    grid = Grid(np.zeros(3), np.ones(3), (sides, sides, 60))
    conductance = np.where(grid.active, 1.0, 0.0)
    low = grid.face_cell.max(axis=1) % 60 < 20
    conductance[low] *= 0.1
    source = np.random.default_rng(3).normal(size=grid.cells)
    _, iterations = Pressure(grid).solve(
        np.zeros(grid.cells), conductance, source, 1e-7
    )
    assert 0 < iterations <= 10
