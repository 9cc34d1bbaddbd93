"""Probes: what happens at points of the bed, row by row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from contbed.errors import SceneError
from contbed.mesh.mesh import Mesh
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.simulation import Simulation

FIELDS = ("eps_s [1]", "u_gas [m/s]", "u_solid [m/s]", "theta [m2/s2]", "p [Pa]")
WITH_HEAT = ("T_gas [K]", "T_solid [K]")


def cells(
    mesh: Mesh, grid: Grid, points: Mapping[str, Sequence[float]]
) -> dict[str, int]:
    """Find the cell of the grid around each named point.

    Raises
    ------
    SceneError : a point that no cell holds, or of another dimension
    """
    place = np.argsort(grid.cells)
    found, problems = {}, []
    for name, point in points.items():
        key = f"output.probes.{name} = {[float(x) for x in point]}"
        if len(point) != grid.dimension:
            problems.append(f"{key}: the mesh has {grid.dimension} coordinates")
            continue
        try:
            found[name] = int(
                place[mesh.skfem.element_finder()(*np.array([point], dtype=float).T)[0]]
            )
        except (ValueError, IndexError):  # IndexError on lines
            low, high = mesh.skfem.p.min(axis=1), mesh.skfem.p.max(axis=1)
            problems.append(
                f"{key}: outside of the mesh, which reaches from {low} to {high} m"
            )
    if problems:
        raise SceneError(problems)
    return found


def columns(bed: Simulation, probes: Mapping[str, int]) -> list[str]:
    """Headers: the name of the probe before that of the field; velocities along the
    last axis.
    """
    names = FIELDS if bed.state.energy is None else (*FIELDS, *WITH_HEAT)
    return [f"{probe} {name}" for probe in probes for name in names]


def row(bed: Simulation, probes: Mapping[str, int]) -> list[float]:
    """Values under the `columns`."""
    fields = [
        bed.state.eps_s,
        bed.state.u_gas[:, -1],
        bed.state.u_solid[:, -1],
        bed.state.theta,
        bed.state.p,
    ]
    if bed.state.energy is not None:
        fields += [bed.state.energy.T_gas, bed.state.energy.T_solid]
    return [float(field[cell]) for cell in probes.values() for field in fields]
