"""Sides of a built-in mesh through which a stream enters and leaves; those of a mesh file are not known here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.packed_bed import scene as s
from contbed.scene.mesh import Mesh, MeshAxisymmetric, MeshFile


def velocity_vector(mesh: Mesh, velocity: Any) -> tuple[float, ...]:
    """Return a velocity, a number or a tuple, as a vector; a number is along the bed axis: x, or z if axisymmetric."""
    if isinstance(velocity, tuple):
        return velocity
    axis = 1 if isinstance(mesh, MeshAxisymmetric) or getattr(mesh, "axisymmetric", False) else 0
    return tuple(velocity if index == axis else 0.0 for index in range(mesh.dimension))


def enters(mesh: Mesh, velocity: tuple[float, ...], side: str) -> int | None:
    """Return 1 if the velocity enters through this side, -1 if it leaves, 0 if it runs along.

    None if that is not known.
    """
    if isinstance(mesh, MeshFile):
        return None
    if side == "axis":
        return 0
    for component, (low, high) in zip(velocity, mesh.sides, strict=True):
        if side in (low, high):
            inward = component if side == low else -component
            return (inward > 0) - (inward < 0)
    return None


def role(mesh: Mesh, velocity: tuple[float, ...], side: str, boundary: Mapping[str, s.Boundary]) -> str | None:
    """Return "inlet", "outlet", "slip" or "no_slip": what the scene says, else by the sign of the velocity."""
    if side in boundary and boundary[side].type is not None:
        return boundary[side].type
    direction = enters(mesh, velocity, side)
    return None if direction is None else {1: "inlet", -1: "outlet", 0: "slip"}[direction]
