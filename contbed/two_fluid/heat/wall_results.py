"""What a run reports of the heat of walls: since the start, as a mean, as a coefficient,
and how far the mesh decides it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from contbed.closures.binding import named
from contbed.two_fluid import scene as t
from contbed.two_fluid.compiled import SMALLEST, Array, Indices
from contbed.two_fluid.heat.model import LAYER
from contbed.two_fluid.heat.wall_laws import PENETRATION, coefficients

if TYPE_CHECKING:
    from contbed.two_fluid.simulation import Simulation

# share of the heat of a wall beyond which the run warns of its mesh
DOUBTED_ERROR = 0.1


def columns(bed: Simulation) -> tuple[str, ...]:
    """Headers of the heat of walls since the start."""
    return tuple(f"heat_{name} [J]" for name, _ in _walls(bed))


def row(bed: Simulation) -> list[float]:
    """Return the heat of each wall since the start [J]."""
    return [float(heat.sum()) for heat, _ in _heats(bed).values()]


def results(
    bed: Simulation, rows: Mapping[str, Array], start: float
) -> dict[str, float]:
    """Return mean heat of walls since `start` [s], coefficients, and estimates of the
    error of the mesh.
    """
    found: dict[str, float] = {}
    late = rows["t [s]"] >= start
    time = rows["t [s]"][late]
    if len(time) < 2 or bed.model.heat is None:
        return found
    period = float(time[-1] - time[0])
    warm = rows["T_solid_mean [K]"][late]
    warm = np.where(np.isnan(warm), rows["T_gas_mean [K]"][late], warm)
    mean = 0.5 * float((warm[1:] + warm[:-1]) @ np.diff(time)) / period
    for name, faces in _walls(bed):
        heat = rows[f"heat_{name} [J]"][late]
        found[f"heat_{name}_W"] = power = float(heat[-1] - heat[0]) / period
        found |= _coefficient(bed, name, faces, power, mean)
        found[f"heat_{name}_error"] = _error(*_heats(bed)[name])
    return found


def judge(bed: Simulation, scene: t.TwoFluidScene) -> list[str]:
    """Return warnings of walls whose heat the mesh decides."""
    found = []
    for name, heats in _heats(bed).items():
        if (error := _error(*heats)) > DOUBTED_ERROR:
            found.append(
                f"boundary.{name}: the mesh beside it leaves its heat uncertain by "
                f"about {error:.0%}: what enters the cells there renews the layer that "
                "the wall heats; make these cells thinner"
            )
    return found + list(_doubted_coefficients(bed, scene))


def _doubted_coefficients(bed: Simulation, scene: t.TwoFluidScene) -> Iterator[str]:
    """Yield warnings of coefficients h whose meaning does not suit the cells beside
    their walls. They pass heat to the middle of these cells.

    A closure is the resistance of the bed beside a wall: what thinner cells conduct
    more easily adds to it. A number is often that outside of the bed: where particles
    are stationary, the bed between wall and middle resists as well.
    """
    heat, energy, grid = bed.model.heat, bed.state.energy, bed.model.grid
    if heat is None or energy is None or heat.physics.conductivity is None:
        return
    depth = grid.geometry.volume[bed.model.boundary_cells]
    depth = depth / grid.geometry.area[grid.interior :]
    places = list(coefficients(scene).items())
    for name, faces in _walls(bed):
        laws = heat.at_faces.law[faces]
        if np.isnan(heat.at_faces.wall[faces]).any() or laws[0] == LAYER:
            continue
        cells = bed.model.boundary_cells[faces]
        eps_s, T = bed.state.eps_s[cells], energy.T_gas[cells]
        k = heat.physics.conductivities(eps_s, T, energy.T_solid[cells]).sum(axis=0)
        h = heat.physics.wall_laws[int(laws[0])](eps_s, T, k)
        place, spec = places[int(laws[0])]
        if named(spec):
            if np.mean(h * depth[faces] < k) > 0.5:
                key = f"boundary.{place}.coefficient" if place else "closures.wall_heat"
                yield (
                    f"boundary.{name}: cells beside it are thinner than the layer k/h "
                    "that its coefficient stands for, whose own resistance adds to "
                    f'it; make them thicker, or take {key} = "{PENETRATION}"'
                )
            continue
        half = 0.5 * h * depth[faces] / np.maximum(k, SMALLEST)
        speed = np.linalg.norm(bed.state.u_solid[cells], axis=1)
        capacity = eps_s * scene.solid.density * heat.physics.cp_solid
        conducts = speed * capacity * depth[faces] < k
        left_out = float(np.mean(np.where(conducts, half / (1.0 + half), 0.0)))
        if left_out > DOUBTED_ERROR:
            yield (
                f"boundary.{name}: its coefficient acts on the middle of the cells "
                "beside it, where particles are stationary: conduction to there, "
                f"{left_out:.0%} of the resistance, is left out; make these cells thinner"
            )


def _walls(bed: Simulation) -> Iterator[tuple[str, Indices]]:
    """Yield names and boundary faces of walls that heat or cool."""
    heat, grid = bed.model.heat, bed.model.grid
    if heat is None:
        return
    heats = ~np.isnan(heat.at_faces.wall) | (heat.at_faces.flux != 0.0)
    for name, faces in grid.boundaries.items():
        if heats[faces - grid.interior].any():
            yield name, faces - grid.interior


def _heats(bed: Simulation) -> dict[str, tuple[Array, Array]]:
    """Return the heat of the faces of each wall [J] since the start, and as it were if
    all that enters the cells there mixed with the layer.
    """
    energy, edges = bed.state.energy, len(bed.model.boundary_cells)
    if energy is None or energy.walls is None:
        return {}
    # of ranks, boundary faces are the last of all faces
    all_faces = energy.walls.heat[-edges:], energy.walls.heat_if_mixed[-edges:]
    return {
        name: (all_faces[0][faces], all_faces[1][faces]) for name, faces in _walls(bed)
    }


def _error(heat: Array, if_mixed: Array) -> float:
    total = float(np.abs(heat).sum())
    return abs(float((if_mixed - heat).sum())) / total if total > 0.0 else 0.0


def _coefficient(
    bed: Simulation, name: str, faces: Indices, power: float, T_bed: float
) -> dict[str, float]:
    """Return the coefficient [W/m2/K] of a wall of a given temperature on the mean
    temperature of the bed; nothing where the two are the same.
    """
    assert bed.model.heat is not None
    area = bed.model.grid.geometry.area[bed.model.grid.interior :][faces]
    driving = float(area @ (bed.model.heat.at_faces.wall[faces] - T_bed))
    if np.isnan(driving) or abs(driving) <= 1e-9 * T_bed * area.sum():
        return {}
    return {f"coefficient_{name}_W_m2K": float(power / driving)}
