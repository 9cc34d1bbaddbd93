"""Every form assembled by DOLFINx on a whole mesh: residual and Jacobian equal those of
dual numbers to rounding.

States are random, so no term is small by chance. Sums of some thousand terms in another
order agree to 1e-12 of the largest entry. The Jacobian is compared in products with
random vectors, with rows and columns of fixed unknowns and without, and so are the sums
and multiples of matrices that time steps take.
"""

import numpy as np
import pytest

pytest.importorskip("dolfinx.fem", reason="DOLFINx is not installed")

from dolfinx_scenes import SCENES

from contbed.loading import from_dict
from contbed.models import plan as make_plan
from contbed.packed_bed.flow import solved_flow
from contbed.packed_bed.run_parts import heat_problem
from contbed.radiation.run import problem_of
from contbed.ranks.engine import Ranks
from contbed.result import Result
from contbed.solvers.linear import constrain

TOLERANCE = 1e-12
NAMES = ["heat_gas_walls", "heat_tables", "heat_axisymmetric", "heat_degree_3", "radiation_in_bed", "heat_hexahedra",
         "heat_sources_and_tubes", "medium_conducting", "line"]  # fmt: skip


def problems(name: str):
    """The scene's problem on both engines, with the same velocities."""
    scene = from_dict(SCENES[name])
    made = one = make_plan(scene)
    other = Ranks().plan(scene)
    if made.scene.heat is None:
        return problem_of(one), problem_of(other)
    flow = None if made.plug else solved_flow(one, None, Result(one))
    return heat_problem(one, flow, Result(one)), heat_problem(
        other, flow, Result(other)
    )


@pytest.mark.parametrize("name", NAMES)
def test_residual_and_jacobian(name: str) -> None:
    one, other = problems(name)
    random = np.random.default_rng(3)
    state = random.uniform(400.0, 800.0, one.system.size)
    if "G" in one.system.fields:
        one.system.part(state, "G")[:] *= 100.0
    heat = hasattr(one, "steady")
    for form in ("steady", "content") if heat else ("assemble",):
        (r1, A1), (r2, A2) = (
            getattr(problem, form)(state, True) for problem in (one, other)
        )
        assert np.abs(r1 - r2).max() <= TOLERANCE * np.abs(r1).max()
        x = random.uniform(-1.0, 1.0, one.system.size)
        terms = abs(A1) @ np.abs(x)
        assert np.abs(abs(A2) @ np.abs(x) - terms).max() <= TOLERANCE * terms.max()
        # contents are constrained together with balances only
        fixed = one.fixed[: None if form != "content" else 0]
        changed = ((A, constrain(A, fixed), A / 3.0 + A) for A in (A1, A2))
        for B1, B2 in zip(*changed, strict=True):
            assert np.abs(B1 @ x - B2 @ x).max() <= TOLERANCE * terms.max()
