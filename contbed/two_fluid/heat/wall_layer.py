"""Heat from a wall into the cell beside it, by a layer that may be thinner than the
cell.

A wall of another temperature than the bed heats a layer of the depth sqrt(pi k t/C)
first, which a cell seldom resolves. So each wall face has its own temperatures T(y, t)
over the distance y from the wall, 0 < y < D within the cell,

    C (dT/dt + u_t . grad T + u_n dT/dy) = d(k dT/dy)/dy,   k dT/dy = -(T_wall - T)/R at y = 0

with the conductivity k and the heat capacity C [J/m3/K] of gas and particles together.
Radiation between particles is part of k beyond those that the wall radiates to.
The heat flux q = -k dT/dy at the wall is what the cell takes. A state has the
deviations from the mean temperature of the cell, which alone carries heat from cell to
cell: no heat is made or lost whatever the layer does. Beside the cell that follows lies
a temperature that draws what the cell gives to its neighbours.

Gas and particles that come from a cell beside the same wall bring its layer with them,
those from elsewhere have one temperature (u_t); what enters opposite to the wall pushes
the layer towards it at a velocity u_n that falls to zero at the wall, what leaves there
draws it away. So particles that stay for tau take the mean q = (T_wall - T) sqrt(4 k C/
(pi tau)) of the packets of Mickley and Fairbanks (1955, AIChE J. 1, 374-384,
doi:10.1002/aic.690010317), and a cell that is thin beside the layer takes the linear
k (T_wall - T)/(distance of its centre).

The layer is solved on SUBLAYERS parts that grow from the wall, first order in time and
implicit; q is linear in the new temperature of the cell, so that the heat of all cells
can be implicit with it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.two_fluid.compiled import SMALLEST, Array, Flags, Indices, kernel
from contbed.two_fluid.fv.grid import Geometry, Grid

# heat of a second of conduction within 1.2 % of the exact one in cells of a quarter to
# 100 times the depth of the layer, 5 % in those of 2000 times
# (test_heat_into_particles_at_rest)
SUBLAYERS, GROWTH = 20, 1.5
# cosine between the normals of two faces, below which they are square to each other
SQUARE = 0.1
# and above which they belong to the same wall
SAME_WALL = 0.9
# exponent with which a cell narrows from the wall: 0 a brick, 1 a triangle, 2 a
# tetrahedron; less than 0 one that widens, beside the inner wall of a ring
WIDENS, NARROWS = -0.5, 3.0
NOWHERE = -1  # no layer beside that of a face


class WallLayers(NamedTuple):
    """Layers beside nl wall faces, each in n = SUBLAYERS parts.

    face, cell (nl,) : of the wall, and the cell there; column (nl,) of the deviations
    in a state
    thickness, node (nl, n) [m] : of parts, and the distance of their means from the
        wall; share (nl, n) : of the volume of the cell
    start (nl + 1,) : of the other faces of the cell in `beside`, with `outward` +1 or
        -1 the sign of fluxes that leave, `opposite` where a face does not stand square
        on the wall, and cell and column of the layer behind it, or NOWHERE
    """

    face: Indices
    cell: Indices
    column: Indices
    thickness: Array
    node: Array
    share: Array
    start: Indices
    beside: Indices
    outward: Array
    opposite: Flags
    beyond_cell: Indices
    beyond_column: Indices


class Surroundings(NamedTuple):
    """What layers feel of their cells in a step.

    k, k_contact (nc,) [W/m/K] : conductivity of gas and particles, with and without the
        radiation between these; content (nc, 2) [J/K]; T (nc, 2) [K]
    links (nf, 2) [W/K] : of conduction between cells; conducted (nc, 2) [W] by it
    carried (nf,) [W/K] : heat capacity that gas and particles move
    T_wall (nl,) [K]; resistance (nl,) [m2 K/W] : of the contact with the wall
    radiation (nl,) [W/m2/K4] : q/(T_wall^4 - T^4) of radiation to the particles at the
        depth `reach` [m]
    mixes : whether all that enters a cell mixes with its layer at once
    """

    k: Array
    k_contact: Array
    content: Array
    T: Array
    links: Array
    conducted: Array
    carried: Array
    T_wall: Array
    resistance: Array
    radiation: Array
    reach: float
    mixes: bool


class Response(NamedTuple):
    """How a layer answers: q = conductance (T_wall - T) + flux for the new T of its cell.

    conductance [W/m2/K], flux [W/m2] (nl,) : also those of radiation alone
    still, driven (nl, n) : parts are at still + P driven beyond the old mean of the
        cell, and take the flux q = P conducts - given
    conducts [W/m2/K], given [W/m2] (nl,)
    passes, radiant (nl,) : share of the heat that the cell passes on to those behind
        it, and that comes by radiation
    """

    conductance: Array
    flux: Array
    still: Array
    driven: Array
    conducts: Array
    given: Array
    passes: Array
    radiant: Array


def wall_layers(grid: Grid, heated: Flags) -> tuple[WallLayers, int]:
    """Return the layers beside boundary faces that are `heated` (nb,), and the number
    of columns that a state has for them.
    """
    g, ni = grid.geometry, grid.interior
    face = ni + np.flatnonzero(heated)
    cell = g.left[face]
    order = np.argsort(cell, kind="stable")
    first = np.searchsorted(cell[order], cell[order])
    slot = np.empty(len(face), dtype=np.int64)
    slot[order] = np.arange(len(face)) - first
    slots = int(grid.halo.max(float(slot.max(initial=-1)))) + 1
    thickness, node, share = _parts(g, face, cell)

    cells = np.concatenate((g.left, g.right))
    faces = np.concatenate((np.arange(len(g.left)), np.arange(ni)))
    others = np.concatenate((g.right, np.full(len(g.left) - ni, NOWHERE), g.left[:ni]))
    outward = np.concatenate((np.ones(len(g.left)), -np.ones(ni)))
    by_cell = np.argsort(cells, kind="stable")
    low, high = (
        np.searchsorted(cells[by_cell], cell, side=side) for side in ("left", "right")
    )
    of = np.repeat(np.arange(len(face)), high - low)
    within = np.arange(len(of)) - np.repeat(
        np.cumsum(high - low) - (high - low), high - low
    )
    at = by_cell[low[of] + within]
    at, of = at[faces[at] != face[of]], of[faces[at] != face[of]]
    cosine = (g.normal[faces[at]] * g.normal[face[of]]).sum(axis=1)
    layer = np.full((len(g.volume) + 1, max(slots, 1)), NOWHERE)
    layer[cell, slot] = np.arange(len(face))
    beyond = np.full(len(at), NOWHERE)
    for known in layer.T:
        found = known[others[at]]
        along = (g.normal[face[found]] * g.normal[face[of]]).sum(axis=1) > SAME_WALL
        beyond = np.where((found != NOWHERE) & along, found, beyond)
    lists = WallLayers(
        face,
        cell,
        slot * SUBLAYERS,
        thickness,
        node,
        share,
        np.searchsorted(of, np.arange(len(face) + 1)),
        faces[at],
        outward[at],
        (np.abs(cosine) > SQUARE) & (beyond == NOWHERE),
        np.where(beyond == NOWHERE, NOWHERE, cell[beyond]),
        np.where(beyond == NOWHERE, NOWHERE, slot[beyond] * SUBLAYERS),
    )
    return lists, slots * SUBLAYERS


def _parts(g: Geometry, face: Indices, cell: Indices) -> tuple[Array, Array, Array]:
    """Thickness and node [m] of the parts of each cell, and their shares of its volume.

    A cell has at y the cross-section A (1 - y/D)^m of that volume and that centre.
    """
    depth = g.volume[cell] / g.area[face]
    middle = g.distance[face] / depth
    m = np.clip((2.0 * middle - 1.0) / (1.0 - middle), WIDENS, NARROWS)[:, None]
    edge = np.concatenate(([0.0], np.cumsum(GROWTH ** np.arange(SUBLAYERS))))
    left = 1.0 - edge / edge[-1]
    share = -np.diff(left ** (m + 1.0), axis=1)
    # of y = D (1 - left), weighed by the cross-section
    inner = -np.diff(left ** (m + 2.0), axis=1) * (m + 1.0) / (m + 2.0)
    whole = (m + 1.0) * depth[:, None]
    return -np.diff(left) * whole, whole * (1.0 - inner / share), share


@kernel
def respond(
    g: Geometry, w: WallLayers, at: Surroundings, dt: float, old: Array, out: Response
) -> None:
    """Find how layers with the deviations `old` (nc, columns) [K] answer in a step of
    `dt` [s].
    """
    n = w.node.shape[1]
    lower, diagonal, upper = np.zeros(n), np.empty(n), np.zeros(n)
    for k in range(len(w.face)):
        c, column, area = w.cell[k], w.column[k], g.area[w.face[k]]
        content = at.content[c, 0] + at.content[c, 1]
        still, driven = out.still[k], out.driven[k]
        still[:], driven[:] = 0.0, 0.0
        out.conductance[k] = out.flux[k] = out.conducts[k] = out.given[k] = 0.0
        out.passes[k] = out.radiant[k] = 0.0
        if at.k[c] <= 0.0 or content <= 0.0:
            continue
        link = left = came = pushed = 0.0
        drawn = -(at.conducted[c, 0] + at.conducted[c, 1]) / area
        for i in range(w.start[k], w.start[k + 1]):
            f = w.beside[i]
            flux = -w.outward[i] * at.carried[f]
            left -= flux
            if w.opposite[i] and not at.mixes:
                pushed += flux
            elif flux > 0.0:
                came += flux
                if w.beyond_cell[i] >= 0:
                    for j in range(n):
                        ahead = old[w.beyond_cell[i], w.beyond_column[i] + j]
                        still[j] += flux * ahead
            if f < len(g.right):
                other = g.left[f] + g.right[f] - c
                for phase in range(2):
                    rate = at.links[f, phase] / area
                    if w.opposite[i]:
                        link += rate
                    else:
                        drawn -= rate * (at.T[c, phase] - at.T[other, phase])
        # content at the start; nearly all of it is new in a cell that was empty
        before = dt / max(content + dt * left, 1e-12 * content)
        conducts = dt * g.volume[c] / content
        contact = at.k_contact[c]
        wall = contact / (at.resistance[k] * contact + w.node[k, 0])
        passed = 0.0
        seen = 0
        while seen < n - 1 and w.node[k, seen] < at.reach:
            seen += 1
        warm = at.T[c, 1] + old[c, column + seen]
        squares = at.T_wall[k] ** 2 + warm**2
        radiation = at.radiation[k] * (at.T_wall[k] + warm) * squares
        for j in range(n):
            rate = conducts / w.thickness[k, j]
            diagonal[j] = 1.0 + came * before
            lower[j] = upper[j] = 0.0
            still[j] = old[c, column + j] + before * still[j]
            if j > 0:
                inner = contact if j <= seen else at.k[c]
                lower[j] = rate * inner / (w.node[k, j] - w.node[k, j - 1])
                if pushed < 0.0:
                    lower[j] -= pushed * before * passed / w.share[k, j]
            else:
                diagonal[j] += rate * wall
                driven[j] += rate * wall
            passed += w.share[k, j]
            if j < n - 1:
                inner = contact if j < seen else at.k[c]
                upper[j] = rate * inner / (w.node[k, j + 1] - w.node[k, j])
                if pushed > 0.0:
                    upper[j] += pushed * before * passed / w.share[k, j]
            else:
                diagonal[j] += rate * link
                still[j] += rate * (link * old[c, column + j] - drawn)
            if j == seen:
                diagonal[j] += rate * radiation
                driven[j] += rate * radiation
            diagonal[j] += lower[j] + upper[j]
        for j in range(1, n):
            share = lower[j] / diagonal[j - 1]
            diagonal[j] -= share * upper[j - 1]
            still[j] += share * still[j - 1]
            driven[j] += share * driven[j - 1]
        mean_still = mean_driven = 0.0
        for j in range(n - 1, -1, -1):
            if j < n - 1:
                still[j] += upper[j] * still[j + 1]
                driven[j] += upper[j] * driven[j + 1]
            still[j] /= diagonal[j]
            driven[j] /= diagonal[j]
            mean_still += w.share[k, j] * still[j]
            mean_driven += w.share[k, j] * driven[j]
        radiant = radiation * (1.0 - driven[seen])
        out.conducts[k] = wall * (1.0 - driven[0]) + radiant
        out.radiant[k] = radiant / out.conducts[k]
        out.given[k] = wall * still[0] + radiation * still[seen]
        out.conductance[k] = out.conducts[k] / (1.0 - mean_driven)
        out.flux[k] = out.conductance[k] * mean_still - out.given[k]
        stored = at.content[c, 0] * at.T[c, 0] + at.content[c, 1] * at.T[c, 1]
        apart = at.T_wall[k] - stored / content
        q = out.conductance[k] * apart + out.flux[k]
        out.passes[k] = min(1.0, max(0.0, drawn / q)) if q != 0.0 else 0.0


@kernel
def settle(w: WallLayers, response: Response, q: Array, new: Array) -> None:
    """Set the deviations `new` (nc, columns) [K] of layers that have taken `q` (nl,)
    [W/m2].
    """
    n = w.node.shape[1]
    for k in range(len(w.face)):
        c, column = w.cell[k], w.column[k]
        P = (q[k] + response.given[k]) / (response.conducts[k] + SMALLEST)
        mean = 0.0
        for j in range(n):
            new[c, column + j] = response.still[k, j] + P * response.driven[k, j]
            mean += w.share[k, j] * new[c, column + j]
        for j in range(n):
            new[c, column + j] -= mean
