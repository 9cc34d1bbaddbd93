"""Evaluates weak forms: `dual` values with exact derivatives, `skfem` assembly, `dolfinx` for MPI by a `tape`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from contbed.meshing.mesh import Mesh

ENGINES = ("skfem", "dolfinx")


def system(mesh: Mesh, fields: Mapping[str, tuple[int, int]], order: int, section: float = 1.0) -> Any:
    """Named unknowns on a mesh, by the engine of the mesh; see `engine.skfem.System`."""
    if mesh.engine == "dolfinx":
        from contbed.engine.dolfinx import System
    else:
        from contbed.engine.skfem import System  # type: ignore[assignment]
    return System(mesh.skfem, fields, order, axisymmetric=mesh.axisymmetric, section=section)
