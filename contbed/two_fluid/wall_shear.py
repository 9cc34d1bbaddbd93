"""How far the mesh decides the shear of the gas on walls where it does not slip.

The velocity beside such a wall rises over a layer whose thickness l follows from the
time t of contact, since the start or, where it is shorter, along the height of the
vessel, and from the drag: 1/l^2 = 4 rho eps/(pi mu t) + beta/mu, so that
mu u/l is the mean shear since the start of a flow over a plate (Stokes' first problem)
and the shear of a steady flow through particles (Brinkman's). Cells whose centres are
at a distance d from the wall give mu u/sqrt(l^2 + d^2), which is exact for the steady
layer on equal cells.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contbed.two_fluid.boundary import WALL
from contbed.two_fluid.compiled import SMALLEST, Array, Indices
from contbed.two_fluid.end_pressure import end_faces

if TYPE_CHECKING:
    from contbed.two_fluid.scene import TwoFluidScene
    from contbed.two_fluid.simulation import Simulation

DOUBTED_ERROR = 0.1  # of the shear, beyond which the run warns of its mesh
SMALL = 0.01  # share of the weight of the particles that a missing shear may be


class Shear(NamedTuple):
    """Force [N] of the gas along a wall on this mesh, in cells that resolve it, and the
    size [m] of these.
    """

    force: float
    resolved: float
    cell_size: float

    @property
    def error(self) -> float:
        """Share of the resolved force that the mesh misses."""
        return 1.0 - self.force / self.resolved if self.resolved > 0.0 else 0.0


def results(bed: Simulation) -> dict[str, float]:
    """Return the estimated error of the shear of each wall."""
    return {f"gas_shear_{name}_error": shear.error for name, shear in shears(bed)}


def judge(scene: TwoFluidScene, bed: Simulation) -> list[str]:
    """Return warnings of walls whose shear the mesh misses, where it is not small beside
    the weight of the particles.
    """
    weight = scene.two_fluid.gravity * bed.model.materials.rho_solid
    weight *= float(bed.state.eps_s @ bed.model.grid.geometry.volume)
    return [
        f"{scene.origin.place(('boundary', name))}: the shear of the gas on this wall is "
        f"about {shear.error:.0%} too small on this mesh; cells of "
        f'{shear.cell_size:.2g} m beside it, or gas.wall = "slip" if it does not matter'
        for name, shear in shears(bed)
        if shear.error > DOUBTED_ERROR and shear.resolved - shear.force > SMALL * weight
    ]


def shears(bed: Simulation) -> Iterator[tuple[str, Shear]]:
    """Yield the name and the shear of each wall where the gas does not slip."""
    grid, gas = bed.model.grid, bed.model.edge.gas
    for name, faces in grid.boundaries.items():
        at = faces - grid.interior
        if (gas.kind[at] == WALL).all() and not gas.slip[at].any():
            yield name, _shear(bed, at)


def _shear(bed: Simulation, at: Indices) -> Shear:
    """Return the shear at boundary faces `at` in the last step."""
    state, grid, materials = bed.state, bed.model.grid, bed.model.materials
    g, faces, cells = grid.geometry, grid.interior + at, bed.model.boundary_cells[at]
    normal, distance = g.normal[faces], g.distance[faces]
    past = state.u_gas[cells] - bed.model.edge.gas.u[at]
    past -= np.sum(past * normal, axis=1)[:, None] * normal
    speed = np.linalg.norm(past, axis=1)
    eps_s, viscosity = state.eps_s[cells], materials.mu_gas
    length = np.ptp(grid.middles[:, -1]) if len(end_faces(grid, -1)) else np.inf
    contact = np.minimum(state.time, length / (speed + SMALLEST)) + SMALLEST
    starting = 4.0 * materials.rho_gas * (1.0 - eps_s) / (np.pi * viscosity * contact)
    dragged = state.properties.drag[cells] * eps_s / viscosity
    thickness: Array = 1.0 / np.sqrt(starting + dragged)
    resolved = g.area[faces] * viscosity * speed / thickness
    force = resolved * thickness / np.hypot(thickness, distance)
    total = float(resolved.sum())
    # d/l of the error that is doubted, of the cell's two halves
    widths = 2.0 * thickness * np.sqrt((1.0 - DOUBTED_ERROR) ** -2 - 1.0)
    size = float(resolved @ widths) / total if total > 0.0 else 0.0
    return Shear(float(force.sum()), total, size)
