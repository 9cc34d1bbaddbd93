"""Order of the time steps: exact decay, the exact semi-discrete solution, and
successive differences.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from manufactured_cases import Heat
from marching import last
from scipy.linalg import expm

from contbed.fem.skfem import System
from contbed.packed_bed.equations import two_energy
from contbed.solvers.linear import Policy
from studies._exact import two_temperature_relaxation
from studies._exact.manufactured import observed_order

END = 1.0
# TR-BDF2 has order 2; between 16 and 32 steps of these smooth solutions the next term
# changes it by less than 0.1
TOLERANCE = 0.1


@dataclass
class Problem:
    """Two-energy forms on a system, as `march` wants them."""

    system: System
    forms: list[Any]
    linear: bool
    fixed: Any = field(default_factory=lambda: np.empty(0, dtype=int))
    weights: Any = 1.0
    fixed_values: Any = 0.0
    time_dependent: bool = False
    nodal_modes: Any = None

    def set_time(self, time: float) -> None:
        """Nothing changes with time."""

    def steady(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Residual of the steady forms."""
        return self.system.assemble(self.forms, state, jacobian)

    def content(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Tested heat content."""
        _, where, c = self.forms[0]
        return self.system.assemble([(two_energy.storage, where, c)], state, jacobian)

    def last(self, state: Any, steps: int | None, tolerance: float = 1.0) -> Any:
        """State at the end after equal steps, or after steps of controlled error."""
        step = None if steps is None else END / steps
        policy = Policy(self.system.mesh.dim())
        return last(self, state, policy, END, tolerance=tolerance, step=step)


def problem(case: Heat, n: int) -> tuple[Problem, Any]:
    """A case with its exact steady values as start and as prescribed values: sources
    drive it away from there.
    """
    manufactured, fixed = case.manufactured(n)
    system = manufactured.system
    nodes = np.unique(
        np.concatenate([system.nodes(name, facets) for name, facets in fixed.items()])
    )
    made = Problem(system, list(manufactured.forms), not case.nonlinear, nodes)
    return made, manufactured.interpolant()


def order(made: Problem, start: Any, expected: Any) -> float:
    errors = [np.abs(made.last(start, steps) - expected).max() for steps in (16, 32)]
    return float(observed_order(errors, [1 / 16, 1 / 32])[0])


def test_linear_against_matrix_exponential() -> None:
    made, start = problem(Heat("triangle", (), 2), 3)
    free = np.setdiff1d(np.arange(made.system.size), made.fixed)
    residual, stiffness = made.steady(start, True)
    mass = made.content(start, True)[1]
    rates = np.linalg.solve(
        mass.toarray()[np.ix_(free, free)], stiffness.toarray()[np.ix_(free, free)]
    )
    limit = -np.linalg.solve(stiffness.toarray()[np.ix_(free, free)], residual[free])
    expected = start.copy()
    expected[free] += limit - expm(-rates * END) @ limit
    assert order(made, start, expected) == pytest.approx(2.0, abs=TOLERANCE)


def test_nonlinear_by_successive_differences() -> None:
    made, start = problem(Heat("line", (), 2, nonlinear=True), 4)
    coarse, middle, fine = (made.last(start, steps) for steps in (8, 16, 32))
    differences = [np.abs(coarse - middle).max(), np.abs(middle - fine).max()]
    assert observed_order(differences, [1 / 8, 1 / 16])[0] == pytest.approx(
        2.0, abs=TOLERANCE
    )


@pytest.fixture
def relaxing() -> tuple[Problem, Any, Any]:
    """Two uniform temperatures that approach each other, and where they are at the
    end.
    """
    capacity_fluid, capacity_solid, exchange = 0.7, 1.9, 1.3

    def phase(capacity: float) -> two_energy.Phase:
        return two_energy.Phase(
            mass_flux=None,
            divergence=None,
            enthalpy=None,
            heat_capacity=None,
            capacity=1.0,
            offset=0.0,
            conductivity=lambda T: 0.4,
            dispersion=None,
            content=lambda T: capacity * T,
            source=0.0,
            tau=None,
        )

    system = Heat("quadrilateral", (), 2).manufactured(2)[0].system
    c = two_energy.Coefficients(
        phase(capacity_fluid),
        phase(capacity_solid),
        lambda fluid, solid: exchange,
        None,
    )
    state = np.empty(system.size)
    system.part(state, "T_fluid")[:], system.part(state, "T_solid")[:] = 1.0, 0.2
    expected = np.empty(system.size)
    ends = two_temperature_relaxation(
        END, capacity_fluid, capacity_solid, exchange, 1.0, 0.2
    )
    system.part(expected, "T_fluid")[:], system.part(expected, "T_solid")[:] = ends
    return (
        Problem(system, [(two_energy.residual, system.cells, c)], True),
        state,
        expected,
    )


def test_exact_relaxation(relaxing: tuple[Problem, Any, Any]) -> None:
    assert order(*relaxing) == pytest.approx(2.0, abs=TOLERANCE)


def test_controlled_error_of_relaxation(relaxing: tuple[Problem, Any, Any]) -> None:
    made, start, expected = relaxing
    # the tolerance bounds the error of one step; over the time of decay, some forty
    # steps, it adds up in part
    assert np.abs(made.last(start, None, 1e-6) - expected).max() <= 10e-6
