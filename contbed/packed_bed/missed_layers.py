"""Layers at walls that cells do not resolve.

Of the flow at no-slip walls, on a mesh of a file: the velocity rises from 0 over delta,
a fraction of the diameter of the particles. A quadratic cell of the height h that
contains such a layer has the polynomial v of the least drag that is 0 at the wall:
v/u = 1 - phi with the integral of phi = h/9, one over the sum of 2 k + 1 of the Legendre
polynomials of degree k = 0, 1, 2. So the wall takes the flow of h/9 instead of delta, and
pressure drop and velocity of the bed are too high by the share (h/9 - delta) A/V of walls
of the area A in a volume V, of drag that grows as the velocity.

Of heat at a wall that is held at another temperature than the bed had: at once it takes
what its nodes hold, c h/6 per kelvin in quadratic cells (h/2 in linear, h/8 in cubic
ones), and later what a half space takes, 2 (k c t/pi)^(1/2), where that is more.
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
# share of a cell that the nodes of a wall hold, by degree of the polynomials
OF_NODES = {1: 1.0 / 2.0, 2: 1.0 / 6.0, 3: 1.0 / 8.0}
# of the heat of a half space, from which a run warns, and the power of a mean of both:
# a wall at 0.4 takes 2.5 % too much (test_heat_that_the_nodes_of_a_wall_take_at_once)
AT_ONCE, BETWEEN = 0.4, 2.5
LEAST_STEP = 0.1  # temperature [K] by which a wall differs from the bed at the start


def missed_layers(plan: Any) -> Iterator[str]:
    """Yield a warning where the pressure drop is too high by what the cells at walls
    lack.
    """
    if plan.plug or not isinstance(plan.scene.mesh, MeshFile):
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


def heat_at_once(plan: Any) -> Iterator[str]:
    """Yield a warning for each wall whose heat is that which its nodes took at once, in
    a run in time.
    """
    scene, medium = plan.scene, plan.medium
    start = scene.initial.given("solid")
    if scene.heat is None or scene.time is None or not isinstance(start, float):
        return
    for name, table in scene.boundary.items():
        T = table.temperature
        if not isinstance(T, float) or abs(T - start) < LEAST_STEP:
            continue
        contents = (medium.content_fluid, medium.content_solid)
        capacity = sum(float(of(T) - of(start)) for of in contents) / (T - start)
        conductivity = sum(
            float(of(0.5 * (T + start)))
            for of in (medium.conductivity_fluid, medium.conductivity_solid)
        )
        depth = float(np.mean(_heights(plan.mesh, name)))
        held = OF_NODES[scene.solver.degree] * depth * capacity
        passed = 2.0 * (conductivity * capacity * scene.time.end / np.pi) ** 0.5
        if held > AT_ONCE * passed > 0.0:
            heated = f"{1e3 * passed / capacity:.2g} mm"
            ratio = (1.0 + (held / passed) ** BETWEEN) ** (1.0 / BETWEEN)
            much = (
                f"{ratio - 1.0:.0%} too high"
                if ratio < 2.0
                else f"{ratio:.2g} times too high"
            )
            yield (
                f"{scene.origin.at(('boundary', name))}: boundary.{name}: cells at this "
                f"wall are {1e3 * depth:.3g} mm thick, and at the end the bed is heated "
                f"{heated} deep: the heat through the wall is "
                f"about {much}; leave out mesh.cells, or make the cells there "
                f"thinner than {heated}"
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
