"""Every form assembled by DOLFINx on a whole mesh: residual and Jacobian equal those of dual numbers to rounding.

States are random, so no term is small by chance. Sums of some thousand terms in another order agree to 1e-12 of the
largest entry. The Jacobian is compared in products with random vectors, with rows and columns of fixed unknowns and
without, and so are the sums and multiples of matrices that time steps take, and the borders that branches take.
"""

import numpy as np
import pytest

pytest.importorskip("dolfinx.fem", reason="DOLFINx is not installed")

from dolfinx_scenes import SCENES

from contbed.bubbling_bed.problem import BubblingProblem
from contbed.developed_flow.problem import DevelopedProblem
from contbed.fem.dolfinx import on_dolfinx
from contbed.loading import from_dict
from contbed.models import plan as make_plan
from contbed.packed_bed.shared import heat_problem, solved_flow
from contbed.radiation.run import problem_of
from contbed.result import Result
from contbed.solvers.linear import bordered, constrain, scaled

TOLERANCE = 1e-12
NAMES = ["heat_gas_walls", "heat_tables", "heat_axisymmetric", "heat_degree_3", "radiation_in_bed", "heat_hexahedra",
         "heat_sources_and_tubes", "medium_conducting", "line", "bubbling_frozen", "bubbling_settling",
         "bubbling_reacting", "developed_pipe"]  # fmt: skip
POINTWISE = {"bubbling_bed": BubblingProblem, "fully_developed": DevelopedProblem}


def problems(name: str):
    """The scene's problem on both engines, with the same velocities."""
    made = make_plan(from_dict(SCENES[name]))
    one, other = made, on_dolfinx(made)
    if made.scene.kind in POINTWISE:
        return POINTWISE[made.scene.kind](one), POINTWISE[made.scene.kind](other)
    if made.scene.heat is None:
        return problem_of(one), problem_of(other)
    flow = None if made.plug else solved_flow(one, None, Result(one))
    return heat_problem(one, flow, Result(one)), heat_problem(other, flow, Result(other))


@pytest.mark.parametrize("name", NAMES)
def test_residual_and_jacobian(name: str) -> None:
    one, other = problems(name)
    random = np.random.default_rng(3)
    state = random.uniform(400.0, 800.0, one.system.size)
    if type(one) in POINTWISE.values():
        start = one._start(1100.0) if isinstance(one, BubblingProblem) else one.start(0.03)
        state = start * random.uniform(0.98, 1.02, one.system.size)
    elif "G" in one.system.fields:
        one.system.part(state, "G")[:] *= 100.0
    heat = hasattr(one, "steady")
    for form in ("steady", "content") if heat else ("assemble",):
        (r1, A1), (r2, A2) = (getattr(problem, form)(state, True) for problem in (one, other))
        assert np.abs(r1 - r2).max() <= TOLERANCE * np.abs(r1).max()
        x = random.uniform(-1.0, 1.0, one.system.size)
        terms = abs(A1) @ np.abs(x)
        assert np.abs(abs(A2) @ np.abs(x) - terms).max() <= TOLERANCE * terms.max()
        border = (*(terms.max() * random.uniform(-1.0, 1.0, (2, len(x)))), 0.7 * terms.max())
        fixed = one.fixed[: None if form != "content" else 0]  # contents are constrained together with balances only
        changed = ((A, constrain(A, fixed), A / 3.0 + A, scaled(A, x), bordered(A, *border)) for A in (A1, A2))
        for B1, B2 in zip(*changed, strict=True):
            y = np.resize(x, B1.shape[0])
            assert np.abs(B1 @ y - B2 @ y).max() <= TOLERANCE * terms.max()
