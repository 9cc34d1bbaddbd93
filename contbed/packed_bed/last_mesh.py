"""Number of cells of the last mesh of a steady plane or volume, and the cost of the run, from a trial of its first.

The trial goes through the meshes of the run itself until `BUDGET` is spent or the next mesh is too dear. The estimated
errors tell that next mesh, which has nearly as many cells as the last. A first mesh that is too dear by itself is tried
with larger cells.
"""

from __future__ import annotations

import time as clock
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.packed_bed.plan import Plan
from contbed.packed_bed.run import on_one_mesh
from contbed.result import Result
from contbed.solvers.cost import RATES, START_UP

BUDGET = 2.0  # s of processor time after which no further mesh is tried
DEAREST = (
    5.0  # s of processor time of a mesh that is tried, predicted by the rates of `solvers.cost` and by the mesh before
)
FEWEST = 3  # vertices that stay in a direction
# The time of a mesh grows with this power of its cells, by dimension: that of a few thousand cells, in which factors
# of the flow and of both temperatures fill in; measured on random planes and on boxes with walls.
POWER = {2: 1.5, 3: 1.8}
BALANCES = 0.5  # time of balances and results, over that of the last mesh
GROWING = 1.2  # growth of the number of cells above which the next mesh may not be the last
ONE_OR_TWO = 2.0**0.5  # meshes that follow then: one or a second one like it, the middle of both by their ratio


@dataclass(frozen=True)
class LastMesh:
    """Cells of the last mesh of a run and processor time of the run [s]; `ended` if the trial has reached that mesh."""

    cells: int
    seconds: float
    ended: bool


def last_mesh(plan: Plan) -> LastMesh | None:
    """Predict the last mesh of a steady plan whose meshes are chosen by their errors; None if the trial fails.

    Cells and processor time are within a factor of 2 of those of the run, on random planes and boxes.
    """
    result, began = Result(plan), clock.process_time()
    flow: Any = None
    estimate: Any = None
    plan = _affordable(plan)
    with suppress(Exception):  # a run that fails is told by the run
        for attempt in range(plan.adaptations + 1):
            before = clock.process_time()
            better, flow, estimate = on_one_mesh(plan, flow, estimate, attempt == plan.adaptations, result)
            now = clock.process_time()
            cells = plan.mesh.skfem.nelements
            if better is None:
                return LastMesh(cells, now - began, True)
            growth = better.mesh.skfem.nelements / cells
            following = (now - before) * growth ** POWER[plan.mesh.skfem.dim()]
            if now - began > BUDGET or following > DEAREST:
                meshes = (ONE_OR_TWO if growth > GROWING else 1.0) + BALANCES
                return LastMesh(better.mesh.skfem.nelements, now - began + meshes * following, False)
            plan = better
    return None


def _affordable(plan: Plan) -> Plan:
    """Return the plan on a mesh that takes at most `DEAREST`, with every other vertex left out as often as it takes."""
    dimension = plan.mesh.skfem.dim()
    rate = RATES["multigrid" if plan.policy.multigrid and dimension == 3 else "skfem", dimension]
    while rate.time(sum(plan.unknowns().values())) - START_UP > DEAREST:
        vertices = [np.unique(x) for x in plan.mesh.skfem.p]
        if max(len(x) for x in vertices) <= FEWEST:
            break
        plan = plan.on([np.append(x[:-1:2], x[-1]) if len(x) > FEWEST else x for x in vertices])
    return plan
