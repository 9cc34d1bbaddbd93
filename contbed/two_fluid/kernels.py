"""The kernels of a step that differ between rectangular and other grids, under one name
each.

Those of any grid run over single faces. Those of rectangular grids run over rows of
faces, on several cores, and take fields by component. A model chooses its table once,
by its grid; both take the same arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from contbed.two_fluid import (
    cell_velocities,
    face_velocities,
    pressure_equation,
    solids_pressure,
    stress,
)
from contbed.two_fluid.cell_velocities import FaceVelocities, Gathered
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.fv import diffusion, reconstruction
from contbed.two_fluid.fv import gradient as gradients
from contbed.two_fluid.fv.grid import Geometry, Grid, over_rows
from contbed.two_fluid.rectangular import cells, fields, solids
from contbed.two_fluid.rectangular import faces as faces_of_rows
from contbed.two_fluid.rectangular import stress as stress_of_rows

Kernel = Callable[..., object]


class Kernels(NamedTuple):
    """Kernels of one grid, without its geometry as their first argument; the
    functions of any grid describe them.
    """

    gradient: Kernel
    gradient_solid: Kernel
    predictor_half_step: Kernel
    convect: Kernel
    conduct: Kernel
    divergence: Kernel
    assemble_compaction: Kernel
    add_compaction_flux: Kernel
    add_compaction_velocity: Kernel
    add_stress: Kernel
    predict_on_faces: Kernel
    reconstruct_fractions: Kernel
    assemble_pressure: Kernel
    correct_fluxes: Kernel
    gather: Kernel
    face_residual: Kernel
    divergence_solid: Kernel


def kernels_of(grid: Grid) -> Kernels:
    """Return the kernels for a grid."""
    if grid.rows is None:
        return Kernels(*(partial(kernel, grid.geometry) for kernel in ON_ANY_CELLS))
    return Kernels(*(partial(kernel, grid) for kernel in ON_ROWS))


def _predictor_half_step(g: Geometry, *arguments: Any) -> None:
    reconstruction.predictor_half_step(*arguments)


def _divergence(
    g: Geometry, flux: Array, face: Array, values: Array, out: Array
) -> None:
    reconstruction.divergence(g, flux, face, values, np.empty_like(out), out)


def _gather(
    g: Geometry,
    faces: FaceVelocities,
    eps_s: Array,
    grad_gas: Array,
    grad_solid: Array,
    out: Gathered,
) -> None:
    cell_velocities.gather_gas(g, faces, grad_gas, grad_gas, False, out)
    cell_velocities.gather_solid(g, faces, eps_s, grad_solid, grad_solid, False, out)


def _on_rows(kernel: Kernel, *by_component: int) -> Kernel:
    """Return a function of a grid that calls a kernel over its rows.

    The kernel takes the arguments at the positions `by_component` by component.
    """

    def call(grid: Grid, *arguments: Any) -> None:
        given = list(arguments)
        for position in by_component:
            given[position] = given[position].T
        over_rows(grid, kernel, *given)

    return call


ON_ANY_CELLS = Kernels(
    gradient=gradients.gradient,
    gradient_solid=gradients.gradient_solid,
    predictor_half_step=_predictor_half_step,
    convect=reconstruction.convect,
    conduct=diffusion.conduct,
    divergence=_divergence,
    assemble_compaction=solids_pressure.assemble_compaction,
    add_compaction_flux=solids_pressure.add_compaction_flux,
    add_compaction_velocity=solids_pressure.add_compaction_velocity,
    add_stress=stress.add_stress,
    predict_on_faces=face_velocities.predict_on_faces,
    reconstruct_fractions=face_velocities.reconstruct_fractions,
    assemble_pressure=pressure_equation.assemble_pressure,
    correct_fluxes=pressure_equation.correct_fluxes,
    gather=_gather,
    face_residual=cell_velocities.face_residual,
    divergence_solid=cell_velocities.divergence_solid,
)
ON_ROWS = Kernels(
    gradient=_on_rows(fields.gradient, 0, 2),
    gradient_solid=_on_rows(fields.gradient_solid, 1, 3),
    predictor_half_step=_on_rows(fields.predictor_half_step, 1, 2, 3, 4, 5),
    convect=_on_rows(fields.convect, 1, 2),
    conduct=_on_rows(solids.conduct, 4, 5),
    divergence=_on_rows(solids.divergence),
    assemble_compaction=_on_rows(solids.assemble_compaction, 4),
    add_compaction_flux=_on_rows(solids.add_compaction_flux, 1, 2),
    add_compaction_velocity=_on_rows(solids.add_compaction_velocity, 3),
    add_stress=_on_rows(stress_of_rows.add_stress, 2, 3),
    predict_on_faces=_on_rows(faces_of_rows.predict_on_faces),
    reconstruct_fractions=_on_rows(faces_of_rows.reconstruct_fractions, 1),
    assemble_pressure=_on_rows(faces_of_rows.assemble_pressure),
    correct_fluxes=_on_rows(faces_of_rows.correct_fluxes),
    gather=_on_rows(cells.gather, 4),
    face_residual=_on_rows(cells.face_residual, 2),
    divergence_solid=_on_rows(cells.divergence_solid, 2),
)
