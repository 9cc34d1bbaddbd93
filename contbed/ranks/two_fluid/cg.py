"""The conjugate gradients of cg.py on a grid that ranks share: the same iterations, so
the same result to rounding.

All components iterate together, so that an iteration costs one exchange of ghost cells
and two sums over the ranks, whatever the number of components. A component that has
converged stays as it is. Only cells that are solved for are exchanged: they have
numbers of their own, first those that the rank owns, then ghost cells.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.compiled import Array, Flags
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.linear.cg import (
    QUIET,
    STIFF,
    System,
    add_links,
    advance,
    mark_neighbours,
    product,
    rows_of,
    scale_of,
    values_of,
)


def solve_on_ranks(
    grid: Grid, system: System, explicit: float, tolerance: float, most: int, x: Array
) -> int:
    """Solve for `x` (nc, m), ghost cells included; return the number of iterations, -1
    if too many.

    explicit : links of a cell over its content above which it is stiff
    tolerance : of the residual, relative in the norm of the inverse diagonal
    """
    g, halo = grid.geometry, grid.halo
    add_links(g, system)
    x[:] = system.rhs / system.content
    stiff: Flags = np.asarray((system.links > explicit * system.content).any(axis=1))
    if not halo.any(bool(stiff[halo.cells].any())):
        halo.exchange(x)
        return 0
    state = np.where(stiff, STIFF, QUIET).astype(np.int8)
    halo.exchange(state)
    mark_neighbours(g, state)
    halo.exchange(state)
    rows = rows_of(g, state)
    own = int(np.count_nonzero(state[halo.cells]))
    mine, ghosts = rows.cells[:own], halo.of_numbered(rows.rank)
    components = range(x.shape[1])
    scale = [scale_of(g, system, k, rows) for k in components]
    ghosts.exchange(*scale)
    values = [values_of(system.coef, k, rows, scale[k]) for k in components]
    p = [scale[k] * system.rhs[rows.cells, k] for k in components]
    ghosts.exchange(*p)
    y, r, q = [one[:own].copy() for one in p], [], [np.empty(own) for _ in components]
    for k in components:
        product(g.axes, rows.column, values[k], p[k], q[k])
        r.append(y[k] - q[k])
        p[k][:own] = r[k]
    first, rho = np.split(
        np.array(halo.sum(*(one @ one for one in y), *(one @ one for one in r))), 2
    )
    iterations = 0
    while (going := rho > tolerance**2 * first).any():
        if iterations == most:
            return -1
        iterations += 1
        ghosts.exchange(*p)
        curvature = np.array(
            halo.sum(
                *(
                    product(g.axes, rows.column, values[k], p[k], q[k])
                    for k in components
                )
            )
        )
        alpha = np.where(going, rho / np.where(going, curvature, 1.0), 0.0)
        squares = halo.sum(
            *(advance(alpha[k], p[k], q[k], y[k], r[k]) for k in components)
        )
        before, rho = rho, np.where(going, squares, rho)
        for k in components:
            if going[k]:
                p[k][:own] = r[k] + rho[k] / before[k] * p[k][:own]
    for k in components:
        x[mine, k] = scale[k][:own] * y[k]
    halo.exchange(x)
    return iterations
