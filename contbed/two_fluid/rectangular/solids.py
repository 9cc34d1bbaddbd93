"""Implicit solids pressure and granular temperature on rectangular grids, see
packing.py, granular_temperature.py.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.compiled import SMALLEST, ZERO, Array, inner, kernel
from contbed.two_fluid.fv.grid import Geometry
from contbed.two_fluid.fv.rows import Rows
from contbed.two_fluid.linear.cg import System
from contbed.two_fluid.solids_pressure import (
    Solids,
    compaction_link,
    compaction_stiffness,
    kept_compaction,
    link_outlets,
    push_out,
    sound_share,
)


@inner
def add_outflow(
    g: Geometry, rows: Rows, factor: float, flux: Array, out: Array
) -> None:
    """Add `factor` times what `flux` (nf,) takes out of each cell to `out` (nc,)."""
    for r in range(len(rows.length)):
        face, left, right = rows.face[r], rows.left[r], rows.right[r]
        for i in range(rows.left_from[r], rows.left_to[r]):
            out[left + i] += factor * flux[face + i]
        for i in range(rows.right_from[r], rows.right_to[r]):
            out[right + i] -= factor * flux[face + i]
    for f in range(g.edge_from, g.edge_to):
        out[g.left[f]] += factor * flux[f]


@kernel
def assemble_compaction(
    g: Geometry,
    rows: Rows,
    dt: float,
    solids: Solids,
    flux: Array,
    source: Array,
    system: System,
) -> None:
    """Set links, content and right-hand side for the change of p_solid/rho_s in a
    step; `system` by component.
    """
    drag, coef, content, rhs = (
        solids.drag,
        system.coef[0],
        system.content[0],
        system.rhs[0],
    )
    for c in range(np.uint64(rows.begin), np.uint64(rows.end)):
        content[c] = g.volume[c] / compaction_stiffness(solids.stiffness[c])
        rhs[c] = dt * g.volume[c] * source[c]
    add_outflow(g, rows, -dt, flux, rhs)
    for r in range(len(rows.length)):
        face, left, right = rows.face[r], rows.left[r], rows.right[r]
        for i in range(rows.left_from[r], rows.left_to[r]):
            f, w = face + i, g.weight[face + i]
            mean_drag = w * drag[left + i] + (1.0 - w) * drag[right + i]
            coef[f] = compaction_link(
                dt, mean_drag, solids.rho, g.area[f], g.distance[f]
            )
    link_outlets(g, dt, solids, coef)


@kernel
def add_compaction_flux(
    g: Geometry,
    rows: Rows,
    dt: float,
    system: System,
    y: Array,
    flux: Array,
    velocity: Array,
) -> None:
    """Add the flux that the change y (1, nc) of p_solid/rho_s drives; set its part
    that becomes velocity (nf,).
    """
    coef, content, change_of = system.coef[0], system.content[0], y[0]
    velocity[g.edge_from : g.edge_to] = 0.0
    for r in range(len(rows.length)):
        face, left, right = rows.face[r], rows.left[r], rows.right[r]
        for i in range(rows.left_from[r], rows.left_to[r]):
            f = face + i
            change = -coef[f] * (change_of[right + i] - change_of[left + i]) / dt
            flux[f] += change
            velocity[f] = (
                change
                / g.area[f]
                * sound_share(coef[f], content[left + i], content[right + i])
            )
    push_out(g, dt, coef, change_of, flux)


@kernel
def add_compaction_velocity(
    g: Geometry, rows: Rows, velocity: Array, eps_max: float, s: Array, u: Array
) -> None:
    """Add the compaction velocity of the faces to the velocity u (dim, nc) [m/s]; a
    cell has two faces in each axis.
    """
    speed = np.empty(len(g.right))
    for r in range(len(rows.length)):
        d, face, left, right = rows.axis[r], rows.face[r], rows.left[r], rows.right[r]
        for i in range(ZERO, rows.length[r]):
            f, w = face + i, g.weight[face + i]
            mean = (1.0 - w) * s[left + i] + w * s[right + i]
            speed[f] = (
                0.5
                * velocity[f]
                * kept_compaction(mean, s[left + i], s[right + i], eps_max)
            )
        for i in range(rows.left_from[r], rows.left_to[r]):
            u[d, left + i] += speed[face + i]
        for i in range(rows.right_from[r], rows.right_to[r]):
            u[d, right + i] += speed[face + i]


@kernel
def conduct(
    g: Geometry,
    rows: Rows,
    k: Array,
    values: Array,
    given: Array,
    grad: Array,
    heat: Array,
    links: Array,
) -> None:
    """Add what is conducted between cells [W] to `heat` (1, nc), set `links` (1,
    nf); `grad` is not needed here.
    """
    out, coef = heat[0], links[0]
    rate, link = np.empty(len(g.right)), np.empty(len(g.right))
    for r in range(len(rows.length)):
        face, left, right = rows.face[r], rows.left[r], rows.right[r]
        for i in range(ZERO, rows.length[r]):
            f, a, b = face + i, k[left + i], k[right + i]
            link[f] = 2.0 * a * b / (a + b + SMALLEST) * g.area[f] / g.distance[f]
            rate[f] = link[f] * (values[right + i] - values[left + i])
        for i in range(rows.left_from[r], rows.left_to[r]):
            coef[face + i] = link[face + i]
        for i in range(rows.left_from[r], rows.left_to[r]):
            out[left + i] += rate[face + i]
        for i in range(rows.right_from[r], rows.right_to[r]):
            out[right + i] -= rate[face + i]
    for f in range(g.edge_from, g.edge_to):
        c, outside = g.left[f], given[f - len(g.right)]
        coef[f] = 0.0 if np.isnan(outside) else k[c] * g.area[f] / g.distance[f]
        if coef[f] > 0.0:
            out[c] += coef[f] * (outside - values[c])


@kernel
def divergence(
    g: Geometry, rows: Rows, flux: Array, face: Array, values: Array, out: Array
) -> None:
    """Set `out` (nc,) to -sum of flux (face - value) over the faces of a cell."""
    out[rows.begin : rows.end] = 0.0
    for r in range(len(rows.length)):
        first, left, right = rows.face[r], rows.left[r], rows.right[r]
        for i in range(rows.left_from[r], rows.left_to[r]):
            out[left + i] -= flux[first + i] * (face[first + i] - values[left + i])
        for i in range(rows.right_from[r], rows.right_to[r]):
            out[right + i] += flux[first + i] * (face[first + i] - values[right + i])
    for f in range(g.edge_from, g.edge_to):
        out[g.left[f]] -= flux[f] * (face[f] - values[g.left[f]])
