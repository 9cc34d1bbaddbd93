"""Heat from walls of a given temperature to gas and particles in the cells beside
them: by the layer of `wall_layer`, or by a coefficient, and by radiation.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from contbed.closures.optics import SIGMA
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.heat.model import HeatModel
from contbed.two_fluid.heat.wall_layer import Response, Surroundings, respond, settle
from contbed.two_fluid.model import Model
from contbed.two_fluid.state import Energy, WallMemory

# diameters of particles from a wall within which they take its radiation: all of it in a
# bed to 1e-4
DEPTH = 10.0


class FromWalls(NamedTuple):
    """Heat from nl wall faces to gas and particles of the cells there.

    rate (nl, 2) [W] : at the temperatures before the step; link (nl, 2) [W/K] : by
        which it falls with the new ones
    response, mixed : of the layers, and of those that mix
    """

    rate: Array
    link: Array
    response: Response
    mixed: Response


def memory(heat: HeatModel, model: Model) -> WallMemory | None:
    """Return what walls have done before the first step."""
    if not heat.has_walls:
        return None
    count, faces = len(model.grid.cells), model.grid.face_count
    layers, mixed = (
        np.zeros((count, heat.columns)) if heat.columns else None for _ in range(2)
    )
    return WallMemory(np.zeros(faces), np.zeros(faces), layers, mixed)


def from_walls(
    at: Surroundings,
    k_gas: Array,
    eps_s: Array,
    energy: Energy,
    heat: HeatModel,
    dt: float,
    model: Model,
) -> FromWalls:
    """Return the heat from walls in a step of `dt` [s].

    What a cell passes on comes to each phase as it conducts, what the cell keeps as its
    heat capacity: layer and cell have one temperature.
    """
    w, area = heat.layers, model.grid.geometry.area[heat.layers.face]
    at = _with_contact(at, eps_s, heat, model)
    assert energy.walls is not None
    assert energy.walls.layers is not None
    assert energy.walls.mixed is not None
    response = _response(at, energy.walls.layers, dt, heat, model)
    mixed = _response(at._replace(mixes=True), energy.walls.mixed, dt, heat, model)
    for number, law in enumerate(heat.physics.wall_laws):
        faces = heat.at_faces.law[w.face - model.grid.interior] == number
        cells = w.cell[faces]
        h = law(eps_s[cells], energy.T_gas[cells], at.k[cells])
        T, T_wall = at.T[cells, 1], at.T_wall[faces]
        radiation = at.radiation[faces] * (T_wall + T) * (T_wall**2 + T**2)
        for one in (response, mixed):
            _impose(one, faces, h, radiation)
    keeps = _share_of_gas(at.content[w.cell, 0], at.content[w.cell].sum(axis=1))
    passes = _share_of_gas(k_gas[w.cell], at.k[w.cell])
    of_gas = keeps + response.passes * (passes - keeps)
    of_gas *= 1.0 - response.radiant
    share = area[:, None] * np.stack((of_gas, 1.0 - of_gas), axis=1)
    link = share * response.conductance[:, None]
    apart = at.T_wall[:, None] - at.T[w.cell]
    rate = link * apart + share * response.flux[:, None]
    return FromWalls(rate, link, response, mixed)


def _with_contact(
    at: Surroundings, eps_s: Array, heat: HeatModel, model: Model
) -> Surroundings:
    """Return the surroundings with the resistance of a gap of gas before the particles,
    and the radiation to these: particles within `DEPTH` intercept 1 - exp(-K DEPTH d_p),
    K = 1.5 eps_s/d_p (spheres of geometric optics), and where few fly the rest passes.
    """
    w, faces = heat.layers, heat.layers.face - model.grid.interior
    dense = eps_s[w.cell] / model.materials.eps_max
    intercepted = -np.expm1(-1.5 * DEPTH * eps_s[w.cell])
    radiation = SIGMA * heat.at_faces.emissivity[faces] * intercepted
    return at._replace(resistance=dense * heat.at_faces.gap[faces], radiation=radiation)


def _response(
    at: Surroundings, layers: Array, dt: float, heat: HeatModel, model: Model
) -> Response:
    shape = heat.layers.node.shape
    wide = {"still", "driven"}
    response = Response(
        *(np.empty(shape if name in wide else shape[:1]) for name in Response._fields)
    )
    respond(model.grid.geometry, heat.layers, at, dt, layers, response)
    return response


def _impose(response: Response, faces: Array, h: Array, radiation: Array) -> None:
    """Set coefficients h [W/m2/K] at some faces, whose cells have no layer."""
    response.conductance[faces] = h + radiation
    response.radiant[faces] = radiation / np.maximum(h + radiation, 1e-300)
    response.flux[faces] = response.passes[faces] = response.given[faces] = 0.0
    response.still[faces] = response.driven[faces] = 0.0


def _share_of_gas(gas: Array, both: Array) -> Array:
    return np.divide(gas, both, out=np.ones_like(both), where=both > 0.0)


def after_step(
    energy: Energy,
    walls: FromWalls | None,
    change: Array | None,
    T: Array,
    heat: HeatModel,
    dt: float,
    model: Model,
) -> Energy:
    """Return the state after a step of `dt` [s], with what walls have done.

    `change` (nc, 2) [K] is that of the temperatures with which the heat from walls
    falls, None if it does not; T (nc,) [K] that of gas and particles together.
    """
    before = energy.walls
    if before is None:
        return energy
    g, edges = model.grid.geometry, slice(model.grid.interior, None)
    given = np.zeros(len(before.heat))
    given[edges] = dt * heat.at_faces.flux * g.area[edges]
    after = before._replace(
        heat=before.heat + given, heat_if_mixed=before.heat_if_mixed + given
    )
    if walls is None:
        return replace(energy, walls=after)
    w = heat.layers
    taken = walls.rate.sum(axis=1)
    if change is not None:
        taken -= (walls.link * change[w.cell]).sum(axis=1)
    apart = heat.at_faces.wall[w.face - model.grid.interior] - T[w.cell]
    if_mixed = walls.mixed.conductance * apart + walls.mixed.flux
    assert after.layers is not None
    assert after.mixed is not None
    layers, mixed = after.layers.copy(), after.mixed.copy()
    settle(w, walls.response, taken / g.area[w.face], layers)
    settle(w, walls.mixed, if_mixed, mixed)
    model.grid.halo.exchange(layers, mixed)
    after.heat[w.face] += dt * taken
    after.heat_if_mixed[w.face] += dt * if_mixed * g.area[w.face]
    return replace(energy, walls=after._replace(layers=layers, mixed=mixed))
