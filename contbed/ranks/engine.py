"""The engine for MPI: rank 0 plans, solves and writes, and all ranks compute what is
distributed.

Meshes are distributed for packed beds and radiation (`ranks.system`), and the grid of
two fluids (`ranks.two_fluid`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from contbed import models
from contbed.engine import Engine, Found
from contbed.errors import EngineError
from contbed.mesh.mesh import MeshEngine
from contbed.ranks import dolfinx, parts
from contbed.ranks.group import rank_group, run_on_root
from contbed.ranks.petsc import PetscPolicy
from contbed.ranks.system import System
from contbed.ranks.two_fluid.place import shared_plan
from contbed.scene.tables import SceneBase

INSTEAD = "run it without ranks: leave out mpirun and --engine dolfinx"


class Ranks(Engine):
    """All ranks that mpirun started."""

    name, tangents = "dolfinx", False

    def run(self, main: Callable[[], Found]) -> Found:
        """Run `main` on rank 0 while the others serve it, which return None."""
        found: Found = run_on_root(main)
        return found

    def plan(self, scene: SceneBase) -> Any:
        """Return the plan of a scene for all ranks.

        Raises
        ------
        SceneError : mesh, flow or closures of the scene cannot be used
        EngineError : ranks do not make the scene faster; DOLFINx is missing or of
            another version
        """
        where = scene.origin.name
        make = PLANS.get(scene.kind)
        if make is None:
            why = (
                "it is one line of some hundred unknowns, or its loops share the "
                "cores of one machine by themselves"
            )
            raise EngineError(
                f"{where}: a scene of kind {scene.kind} gains nothing from ranks "
                f"({why}); {INSTEAD}"
            )
        version = dolfinx.modules()[0].__version__
        made = make(scene)
        size = rank_group().comm.size
        how = f"DOLFINx {version} and PETSc on {size} rank{'s' if size > 1 else ''}"
        return replace(made, built=(("engine", how), *made.built))

    def usage(self) -> dict[str, Any]:
        """Return the iterations of each linear solution, and time [s] and
        memory [GB] of each rank.
        """
        all_ranks = rank_group()
        taken = np.asarray(all_ranks.run_on_all(parts.usage)).reshape(-1, 2)
        return {
            "name": self.name,
            "ranks": all_ranks.comm.size,
            "iterations": all_ranks.iterations,
            "cpu_s": taken[:, 0].tolist(),
            "memory_GB": taken[:, 1].tolist(),
        }

    def require_all(self, scene: SceneBase) -> None:
        """Raise EngineError where the other ranks do not serve rank 0."""
        if not rank_group().alone:
            raise EngineError(
                f"{scene.origin.name}: derivatives on several ranks need all of them: "
                "call "
                "contbed.many.derivatives.gradients.gradient(scene, results, keys, "
                'engine="dolfinx") on each, or '
                "mpirun contbed sensitivities"
            )


def _plan_of_forms(scene: SceneBase) -> Any:
    """Return the plan of a scene whose weak forms are compiled.

    Raises
    ------
    EngineError : the scene has equations without a weak form
    """
    plan = models.plan(scene)
    if plan.without_ranks:
        raise EngineError(
            f"{scene.origin.name}: {plan.without_ranks} do not run on several ranks; "
            f"{INSTEAD}"
        )
    return replace(
        plan, mesh=replace(plan.mesh, engine=MeshEngine(System, PetscPolicy))
    )


PLANS: dict[str, Callable[[Any], Any]] = {
    "packed_bed": _plan_of_forms,
    "radiation": _plan_of_forms,
    "two_fluid": shared_plan,
}
