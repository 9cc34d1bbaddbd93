"""Evaluation and assembly of weak forms by `skfem` on one process, and lines of
discontinuous polynomials.

`contbed.ranks` has the same for several ranks, which a mesh then names as its engine.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contbed.fem.skfem import System
    from contbed.mesh.mesh import Mesh, MeshEngine
    from contbed.solvers.linear import Policy


def system(
    mesh: Mesh, fields: Mapping[str, tuple[int, int]], order: int, section: float = 1.0
) -> System:
    """Return named unknowns on a mesh for the engine of that mesh; see
    `fem.skfem.System`.
    """
    made: System = _engine_of(mesh).system(
        mesh.skfem, fields, order, axisymmetric=mesh.axisymmetric, section=section
    )
    return made


def policy(mesh: Mesh, limit_GB: float | None) -> Policy:
    """Return how linear systems on a mesh are solved by its engine, within
    `limit_GB` of memory.
    """
    made: Policy = _engine_of(mesh).policy(mesh.skfem.dim(), limit_GB)
    return made


def _engine_of(mesh: Mesh) -> MeshEngine:
    if mesh.engine is not None:
        return mesh.engine
    from contbed.fem import skfem

    return skfem.ENGINE
