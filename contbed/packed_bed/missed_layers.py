"""Layers of the flow at no-slip walls that the cells of a mesh of a file do not
resolve.

The velocity rises from 0 over delta, a fraction of the diameter of the particles. A
quadratic cell of the height h that contains such a layer has the polynomial v of the
least drag that is 0 at the wall: v/u = 1 - phi with the integral of phi = h/9, one over
the sum of 2 k + 1 of the Legendre polynomials of degree k = 0, 1, 2. So the wall takes
the flow of h/9 instead of delta, and pressure drop and velocity of the bed are too high
by the share (h/9 - delta) A/V of walls of the area A in a volume V, of drag that grows
as the velocity.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.mesh.mesh import Mesh
from contbed.packed_bed.flow import unit_normals
from contbed.packed_bed.grading import wall_layers
from contbed.packed_bed.recognition import velocities
from contbed.scene.mesh import MeshFile

LACKS = 1.0 / 9.0  # of the height of a cell: the integral of phi
LARGE = 5e-3  # share beyond which a run warns


def missed_layers(plan: Any) -> Iterator[str]:
    """Yield a warning where the pressure drop is too high by what the cells at walls
    lack.
    """
    if not isinstance(plan.scene.mesh, MeshFile):
        return
    walls = [name for name, kind in plan.roles.items() if kind == "no_slip"]
    layer = min(wall_layers(plan.scene, plan.medium, *velocities(plan.scene)))
    heights = {name: _heights(plan.mesh, name) for name in walls}
    lacking = sum(
        float(np.mean(np.maximum(LACKS * h - layer, 0.0))) * plan.mesh.measure(name)
        for name, h in heights.items()
    )
    share = lacking / plan.mesh.measure()
    if share > LARGE:
        thickest = max(walls, key=lambda name: float(heights[name].mean()))
        yield (
            f"boundary.{thickest}: the layer of the flow at this wall is "
            f"{1e3 * layer:.2g} mm thick, cells there are "
            f"{1e3 * float(heights[thickest].mean()):.2g} mm: the pressure drop is about "
            f"{share:.1%} too high, by Forchheimer's drag up to twice that; make these "
            "cells thinner"
        )


def _heights(mesh: Mesh, boundary: str) -> Array:
    """Return the heights of the cells over the facets of a boundary [m]."""
    grid = mesh.skfem
    facets = grid.boundaries[boundary]
    corners = grid.p[:, grid.t[:, grid.f2t[0, facets]]]
    inside = grid.p[:, grid.facets[0, facets]][:, None, :] - corners
    depths = np.einsum("fd,dcf->cf", unit_normals(mesh, boundary), inside)
    found: Array = depths.max(axis=0)
    return found
