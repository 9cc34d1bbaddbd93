"""What heat needs of gas, particles and boundaries."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from contbed.two_fluid.compiled import Array
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.heat.wall_layer import WallLayers, wall_layers

# number of the wall law that is the layer of wall_layer.py
LAYER = -1.0


@dataclass(frozen=True)
class Physics:
    """What gas and particles are.

    cp_gas, cp_solid [J/kg/K] : heat capacities
    coefficient : h [W/m2/K] of a particle from eps_s, slip speed [m/s], density of the
        gas over the usual one, T_gas
    conductivity : (k_g, k_s) [W/m/K] (nc,) from eps_s and the temperatures; None where
        nothing is conducted
    density : "constant", or that of an "ideal_gas" which is the usual one at
        T_reference [K] and `pressure` [Pa]
    wall_laws : h [W/m2/K] between walls and bed from eps_s, T_gas and the conductivity
        of both phases
    radiative : conductivity [W/m/K] (nc,) of the radiation between particles, from
        eps_s and T_solid; None without
    """

    cp_gas: float
    cp_solid: float
    coefficient: Callable[[Array, Array, Any, Array], Array]
    conductivity: Callable[[Array, Array, Array], tuple[Array, Array]] | None = None
    density: Literal["constant", "ideal_gas"] = "constant"
    T_reference: float = 293.15
    pressure: float = 101325.0
    wall_laws: tuple[Callable[[Array, Array, Array], Array], ...] = ()
    radiative: Callable[[Array, Array], Array] | None = None

    def conductivities(self, eps_s: Array, T_gas: Array, T_solid: Array) -> Array:
        """Return those [W/m/K] of gas, particles, and radiation between these (3, nc)."""
        found = np.zeros((3, len(eps_s)))
        if self.conductivity is not None:
            found[:2] = self.conductivity(eps_s, T_gas, T_solid)
        if self.radiative is not None:
            found[2] = self.radiative(eps_s, T_solid)
        return found


@dataclass(frozen=True)
class Thermal:
    """Heat at a boundary.

    Temperatures [K] of gas and solids that enter, of a wall, or the flux [W/m2] into
    the bed, which the phases share by their fractions. What is not given is adiabatic;
    what comes back through an outlet has the temperature of the cell.
    law : number of the wall law, or LAYER
    gap [m2 K/W] : resistance of the contact between a wall and a packed bed
    emissivity : of wall and bed together, 1/(1/eps_wall + 1/eps_bed - 1); 0 without
        radiation
    """

    T_gas: float | None = None
    T_solid: float | None = None
    wall: float | None = None
    flux: float = 0.0
    law: float = LAYER
    gap: float = 0.0
    emissivity: float = 0.0


class AtFaces(NamedTuple):
    """Conditions of heat on boundary faces (nb,).

    Temperatures [K] of gas and solids that enter and of walls, not a number where there
    is none, and the flux [W/m2] into the bed; law, gap and emissivity as in `Thermal`.
    """

    T_gas: Array
    T_solid: Array
    wall: Array
    flux: Array
    law: Array
    gap: Array
    emissivity: Array


@dataclass(frozen=True, eq=False)
class HeatModel:
    """Physics, and conditions on boundary faces.

    layers, columns : beside walls of a given temperature, and the number of columns
        that a state has for these; 0 if there is no such wall, here or on other ranks
    has_walls : whether any wall, here or there, gives or takes heat
    """

    physics: Physics
    at_faces: AtFaces
    layers: WallLayers
    columns: int
    has_walls: bool

    @property
    def ideal(self) -> bool:
        """Whether the gas is an ideal gas."""
        return self.physics.density == "ideal_gas"


def build_heat(
    grid: Grid, physics: Physics, conditions: Mapping[str, Thermal]
) -> HeatModel:
    """Model of heat with conditions by boundary name; boundaries without one are
    adiabatic.
    """
    nb = len(grid.geometry.left) - grid.interior
    nowhere = Thermal()
    values = AtFaces(*(np.full(nb, _at_face(nowhere, key)) for key in _OF_THERMAL))
    for name, c in conditions.items():
        at = grid.boundaries[name] - grid.interior
        for array, key in zip(values, _OF_THERMAL, strict=True):
            array[at] = _at_face(c, key)
    return heat_model(grid, physics, values)


_OF_THERMAL = AtFaces._fields


def _at_face(condition: Thermal, key: str) -> float:
    value = getattr(condition, key)
    return np.nan if value is None else float(value)


def heat_model(grid: Grid, physics: Physics, at_faces: AtFaces) -> HeatModel:
    """Model of heat with conditions on boundary faces."""
    heated = ~np.isnan(at_faces.wall)
    has_walls = grid.halo.any(bool(heated.any() or at_faces.flux.any()))
    return HeatModel(physics, at_faces, *wall_layers(grid, heated), has_walls)
