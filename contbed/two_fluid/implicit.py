"""Implicit solution of one field, and what is raised where it fails."""

from __future__ import annotations

import numpy as np

from contbed.errors import ConvergenceError
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.linear.cg import EXPLICIT_SHARE, System
from contbed.two_fluid.model import Model
from contbed.two_fluid.state import State, check_finite

MAX_ITERATIONS = 500
# residual over the right-hand side [-]; fluxes are made from what was found, and keep
# what they carry (test_walls_carry_what_falls_steadily)
TOLERANCE = 1e-7


def solve_system(
    state: State,
    name: str,
    system: System,
    model: Model,
    explicit: float = EXPLICIT_SHARE,
) -> Array:
    """Solution (nc, m) of a symmetric system, see linear/cg.py.

    Raises
    ------
    ConvergenceError : a field is not finite, or too many iterations; with the name of
        the unknown
    """
    x = np.empty_like(system.rhs)
    if (
        model.pressure_solver.solve_diffusion(
            system, explicit, TOLERANCE, MAX_ITERATIONS, x
        )
        < 0
    ):
        check_finite(state, model.grid)
        raise ConvergenceError(
            f"t = {state.time:.6g} s, step {state.steps}: {name} did not converge in "
            f"{MAX_ITERATIONS} iterations; "
            "reduce the Courant number"
        )
    return x
