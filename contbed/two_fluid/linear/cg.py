"""Symmetric systems content x + sum over faces of coef (x - x_neighbour) = rhs, with m unknowns in each cell.

Most cells exchange little in a step: there the exchange, already in rhs as it is at the start of the step, need not be
solved for. Only stiff cells and their neighbours are, as one smaller system; a link between two cells is solved for in
both or in none, so that what one cell loses the other one gets.
"""

from __future__ import annotations

import numpy as np

from contbed.two_fluid.compiled import kernel, summing

QUIET, BESIDE, STIFF = 0, 1, 2


@kernel
def solve(g, coef, links, content, rhs, explicit, tolerance, most, x):
    """Solves for `x` (nc, m); returns the most iterations that a component took, -1 if too many.

    coef (nf, m) : links of faces; those of boundary faces couple with given values
    links (nc, m) : further links of cells to given values; gets those of their faces
    explicit : links of a cell over its content above which it is stiff
    tolerance : of the residual, relative in the norm of the inverse diagonal
    """
    ni, count = len(g.right), len(content)
    for f in range(len(g.left)):
        for k in range(coef.shape[1]):
            links[g.left[f], k] += coef[f, k]
            if f < ni:
                links[g.right[f], k] += coef[f, k]
    state, found = np.zeros(count, dtype=np.int8), False
    for c in range(count):
        for k in range(coef.shape[1]):
            x[c, k] = rhs[c, k] / content[c, k]
            if links[c, k] > explicit * content[c, k]:
                state[c] = STIFF
                found = True
    if not found:
        return 0
    rank, cells, column, face = rows(g, state)
    longest = 0
    for k in range(coef.shape[1]):
        scale, target = np.empty(len(cells)), np.empty(len(cells))
        for i in range(len(cells)):
            scale[i] = content[cells[i], k] + links[cells[i], k]
        for f in range(ni):
            left, right = rank[g.left[f]], rank[g.right[f]]
            if left >= 0 and right < 0:
                scale[left] -= coef[f, k]
            elif right >= 0 and left < 0:
                scale[right] -= coef[f, k]
        for i in range(len(cells)):
            scale[i] = 1.0 / np.sqrt(scale[i])
            target[i] = scale[i] * rhs[cells[i], k]
        values = np.zeros(column.shape)
        for i in range(len(cells)):
            for j in range(column.shape[1]):
                if column[i, j] != i:
                    values[i, j] = coef[face[i, j], k] * scale[i] * scale[column[i, j]]
        iterations = conjugate(g.axes, column, values, target, tolerance, most)
        if iterations < 0:
            return -1
        longest = max(longest, iterations)
        for i in range(len(cells)):
            x[cells[i], k] = scale[i] * target[i]
    return longest


@kernel
def rows(g, state):
    """The system of the STIFF cells and their neighbours: the number of each cell in it, -1 where it has none; the cell
    of each number; for each row the numbers of its neighbours and their faces, its own number in place of a missing
    one.
    """
    ni, most = len(g.right), 2 * len(g.axes)
    for f in range(ni):
        left, right = g.left[f], g.right[f]
        if state[left] == STIFF and state[right] == QUIET:
            state[right] = BESIDE
        elif state[right] == STIFF and state[left] == QUIET:
            state[left] = BESIDE
    rank, cells = np.full(len(state), -1, dtype=np.int32), np.flatnonzero(state)
    column, face = np.empty((len(cells), most), dtype=np.uint32), np.empty((len(cells), most), dtype=np.uint32)
    filled = np.zeros(len(cells), dtype=np.uint32)
    for i in range(len(cells)):
        rank[cells[i]] = i
        column[i] = i
    for f in range(ni):
        left, right = rank[g.left[f]], rank[g.right[f]]
        if left >= 0 and right >= 0:
            for here, there in ((left, right), (right, left)):
                column[here, filled[here]] = there
                face[here, filled[here]] = f
                filled[here] += 1
    return rank, cells, column, face


@summing
def product(axes, column, values, p, q):
    """q = p - values times the neighbours; returns p . q."""
    total = 0.0
    for i in range(len(p)):
        row = p[i]
        for j in range(2 * len(axes)):
            row -= values[i, j] * p[column[i, j]]
        q[i] = row
        total += row * p[i]
    return total


@summing
def advance(alpha, p, q, x, r):
    """x + alpha p and r - alpha q in place; returns r . r."""
    total = 0.0
    for i in range(len(p)):
        x[i] += alpha * p[i]
        r[i] -= alpha * q[i]
        total += r[i] * r[i]
    return total


@kernel
def conjugate(axes, column, values, x, tolerance, most):
    """Conjugate gradients for a matrix with a diagonal of ones; `x` holds the right-hand side, and gets the solution.

    Returns the iterations, -1 if too many.
    """
    r, p, q = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    product(axes, column, values, x, q)
    first = rho = 0.0
    for i in range(len(x)):
        r[i] = p[i] = x[i] - q[i]
        first += x[i] * x[i]
        rho += r[i] * r[i]
    for iteration in range(most):
        if rho <= tolerance**2 * first:
            return iteration
        before = rho
        rho = advance(rho / product(axes, column, values, p, q), p, q, x, r)
        for i in range(len(p)):
            p[i] = r[i] + rho / before * p[i]
    return -1 if rho > tolerance**2 * first else most
