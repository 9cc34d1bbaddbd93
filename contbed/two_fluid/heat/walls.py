"""Heat from walls of a given temperature to gas and particles in the cells beside
them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.two_fluid.compiled import Array
from contbed.two_fluid.heat.model import HeatModel
from contbed.two_fluid.heat.wall_layer import Response, Surroundings, respond, settle
from contbed.two_fluid.model import Model
from contbed.two_fluid.state import Energy


class FromWalls(NamedTuple):
    """Heat from nl wall faces to gas and particles of the cells there.

    rate (nl, 2) [W] : at the temperatures before the step; link (nl, 2) [W/K] : by
        which it falls with the new ones
    response : of the layers
    """

    rate: Array
    link: Array
    response: Response


def from_walls(
    at: Surroundings,
    k_gas: Array,
    energy: Energy,
    heat: HeatModel,
    dt: float,
    model: Model,
) -> FromWalls:
    """Return the heat from walls in a step of `dt` [s].

    What a cell passes on comes to each phase as it conducts, what the cell keeps as its
    heat capacity: layer and cell have one temperature.
    """
    w, g = heat.layers, model.grid.geometry
    assert energy.layers is not None
    count, parts = w.node.shape
    wide, flat = (count, parts), (count,)
    response = Response(*map(np.empty, (flat, flat, wide, wide, flat, flat, flat)))
    respond(g, w, at, dt, energy.layers, response)
    keeps = _share_of_gas(at.content[w.cell, 0], at.content[w.cell].sum(axis=1))
    passes = _share_of_gas(k_gas[w.cell], at.k[w.cell])
    of_gas = keeps + response.passes * (passes - keeps)
    share = g.area[w.face][:, None] * np.stack((of_gas, 1.0 - of_gas), axis=1)
    link = share * response.conductance[:, None]
    apart = at.T_wall[:, None] - at.T[w.cell]
    return FromWalls(link * apart + share * response.flux[:, None], link, response)


def _share_of_gas(gas: Array, both: Array) -> Array:
    return np.divide(gas, both, out=np.ones_like(both), where=both > 0.0)


def after_step(
    energy: Energy,
    walls: FromWalls,
    change: Array | None,
    heat: HeatModel,
    model: Model,
) -> tuple[Array, Array]:
    """Return the layers after a step, and the heat (nl,) [W] that walls have given.

    `change` (nc, 2) [K] is that of the temperatures with which the heat from walls
    falls, None if it does not.
    """
    w = heat.layers
    taken = walls.rate.sum(axis=1)
    if change is not None:
        taken -= (walls.link * change[w.cell]).sum(axis=1)
    assert energy.layers is not None
    layers = energy.layers.copy()
    settle(w, walls.response, taken / model.grid.geometry.area[w.face], layers)
    return layers, taken
