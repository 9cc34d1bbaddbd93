"""One sphere that conducts and reacts; the gas that it makes flows out at once and
carries heat.

    dm_k/dt = omega_k,    omega_k = sum_j (y_kj - [k reacts in j]) r_j,    r_j = A_j exp(-E_j/(R T)) m_j
    rho_0 dh/dt = div(k grad T) - div(g c_g (T - T_0)) - rho_0 sum_j q_j r_j + rho_0 sum_k h_k omega_k + ...
    div g = rho_0 omega_gas,    omega_gas = -sum_k omega_k

m_k   mass of constituent k per mass of fresh particle      r_j   rate of reaction j [1/s]
h     sum_k m_k h_k [J/kg of fresh particle]                q_j   heat that it takes up [J/kg]
g     mass flux of gas, radial [kg/m2/s]                    T_0   temperature at the start [K]
k     conductivity, linear in what is left of the fresh constituents [W/m/K]
h_k   of constituent k, the integral of c_k from T_0

Heats of reaction hold at the temperature of the reaction; the terms h_k omega_k and
c_g (T - T_0) omega_gas say so, and make the balance of the whole exact. At the surface

    k dT/dr = h (T_furnace - T) + emissivity sigma (T_furnace^4 - T^4),    or T is given.

Finite volumes on shells of equal thickness, of second order; TR-BDF2 with error control
(`course.dirk`).

Source: Park, Atreya, Baum, Combust. Flame 157 (2010) 481,
    doi:10.1016/j.combustflame.2009.10.006, for wood.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.optimize import brentq

from contbed.closures.optics import SIGMA
from contbed.fem.ad.dual import Dual
from contbed.materials.curve import Function

Array = NDArray[np.float64]
# [J/kg] by which equations of heat are divided, to be of the order of the equations of
# mass
SCALE_HEAT = 1e5
OUTERMOST = 2  # offset of slots of the outermost shell, beyond those of neighbours
SCALE_SURFACE = 1e4  # [W/m2] by which that of the surface is divided


@dataclass(frozen=True)
class Material:
    """Numbers of the particle; constituents and reactions in the order of the scene.

    heat_capacity : of each constituent a number [J/kg/K], or the enthalpy above that at
        the start as a function of T [J/kg]
    fresh : (K,) mass fractions at the start
    rate, activation, heat : (J,) [1/s], E/R [K], [J/kg]; reactant : (J,) numbers of
        constituents
    change : (K, J) mass of each constituent made per mass that reacts, negative for the
        reactant
    conductivity : fresh and of the product, functions of T [W/m/K]
    """

    radius: float
    density: float
    start: float
    conductivity: tuple[Function, Function]
    gas_heat_capacity: float
    heat_capacity: tuple[float | Function, ...]
    fresh: Array
    rate: Array
    activation: Array
    heat: Array
    reactant: NDArray[np.int64]
    change: Array


@dataclass(frozen=True)
class Surface:
    """Condition at the surface; functions of time [s] that return K. `given` is None
    with a furnace.
    """

    given: Callable[[float], float] | None
    furnace: Callable[[float], float]
    coefficient: float
    emissivity: float


class Sphere:
    """The discrete problem, as `course.march` takes it.

    The state holds T and each m_k of all shells, then the flow of gas through the outer
    face of each per mass of fresh particle [1/s], then the temperature of the surface.
    """

    linear, time_dependent, nodal_modes = False, True, None

    def __init__(self, material: Material, surface: Surface, shells: int, span: float):
        self.material, self.surface, self.shells = material, surface, shells
        faces = np.linspace(0.0, 1.0, shells + 1)
        self.volume = faces[1:] ** 3 - faces[:-1] ** 3
        self.step = material.radius / shells
        # area of the inner faces per volume of the particle
        self.area = 3.0 * faces[1:-1] ** 2 / material.radius
        self.count = len(material.fresh)
        self.size = (self.count + 2) * shells + 1
        self.fixed, self.fixed_values = np.empty(0, dtype=np.int64), np.empty(0)
        self.weights = np.ones(self.size)
        # errors of masses count as those of theta
        self.weights[shells : (self.count + 1) * shells] = span
        self.time = 0.0

    def set_time(self, time: float) -> None:
        """Put the surroundings of a time [s] in place."""
        self.time = time

    def initial(self) -> Array:
        """Return the fresh particle; the flow of gas and the surface follow from its
        temperature.
        """
        n, m = self.shells, self.material
        state = np.empty(self.size)
        state[:n] = m.start
        state[n : (self.count + 1) * n] = np.repeat(m.fresh, n)
        T, masses, *_ = self._fields(state)
        gas = -sum(rate.value for rate in self._made(T, self._rates(T, masses)))
        state[(self.count + 1) * n : -1] = np.cumsum(self.volume * gas)
        return self.with_surface(state)

    def with_surface(self, before: Array) -> Array:
        """Return a state whose surface is as hot as the surroundings of the present
        time make it.
        """
        state = before.copy()
        if self.surface.given is not None:
            state[-1] = self.surface.given(self.time)
            return state
        low, high = sorted((state[self.shells - 1], self.surface.furnace(self.time)))

        def unbalanced(T: float) -> float:
            state[-1] = T
            return float(self.steady(state, False)[0][-1])

        state[-1] = brentq(unbalanced, low - 1.0, high + 1.0)
        return state

    def masses(self, state: Array) -> Array:
        """Return the mass of each constituent in each shell (K, shells) over that of
        the fresh shell.
        """
        found: Array = state[self.shells : (self.count + 1) * self.shells].reshape(
            self.count, self.shells
        )
        return found

    def left(self, state: Array) -> float:
        """Return the mass that is left over that of the fresh particle."""
        return float(self.volume @ self.masses(state).sum(axis=0))

    def centre(self, state: Array) -> float:
        """Return the temperature in the centre, by the parabola through the two
        innermost shells [K].
        """
        return float(9.0 * state[0] - state[1]) / 8.0

    def content(self, state: Array, jacobian: bool) -> tuple[Array, Any]:
        """Return masses, and heat over `SCALE_HEAT`, of all shells per mass of fresh
        particle.
        """
        T, masses, *_ = self._fields(state, jacobian)
        heat = self._enthalpy(T, masses)
        rows = [
            (0, heat * (self.volume / SCALE_HEAT)),
            *((1 + k, m * self.volume) for k, m in enumerate(masses)),
        ]
        return self._assemble([(block, 0, value) for block, value in rows], jacobian)

    def steady(self, state: Array, jacobian: bool) -> tuple[Array, Any]:
        """Return what leaves each shell less what is made in it, and the conditions
        of gas flow and surface.
        """
        m, n = self.material, self.shells
        T, masses, gas, surface = self._fields(state, jacobian)
        rates = self._rates(T, masses)
        made = self._made(T, rates)
        released = (
            -sum(rate * q for rate, q in zip(rates, m.heat, strict=True))
            if rates
            else 0.0 * T
        )
        gas_heat = m.gas_heat_capacity * (T - m.start)
        released = released + self._enthalpy(T, made) - sum(made) * gas_heat
        conductivity = self._conductivity(T, masses)
        parts = [(0, 0, -released * (self.volume / SCALE_HEAT))]
        parts += [(1 + k, 0, -rate * self.volume) for k, rate in enumerate(made)]
        # inner faces: shells on both sides
        left, right = (_cut(T, side) for side in (0, 1))
        k_left, k_right = (_cut(conductivity, side) for side in (0, 1))
        flow = 2.0 * k_left * k_right / (k_left + k_right) * (left - right)
        heat = flow * (self.area / (self.step * m.density)) + _cut(
            gas, 0
        ) * m.gas_heat_capacity * (0.5 * (left + right) - m.start)
        parts += [(0, 0, heat / SCALE_HEAT), (0, 1, -heat / SCALE_HEAT)]
        # the outer face
        outer, k_outer, gas_outer = (_last(item) for item in (T, conductivity, gas))
        flux = k_outer * (outer - surface) * (2.0 / self.step)  # [W/m2] outwards
        lost = flux * (
            3.0 / (m.radius * m.density)
        ) + gas_outer * m.gas_heat_capacity * (surface - m.start)
        parts.append((0, n - 1, lost / SCALE_HEAT))
        # algebraic: flow of gas, surface
        grown = (
            gas - _from_inside(gas) + sum(made) * self.volume
            if made
            else gas - _from_inside(gas)
        )
        parts.append((1 + self.count, 0, grown))
        if self.surface.given is not None:
            condition = surface - self.surface.given(self.time)
        else:
            furnace = self.surface.furnace(self.time)
            heating = self.surface.coefficient * (furnace - surface)
            heating = heating + self.surface.emissivity * SIGMA * (
                furnace**4 - surface * surface * surface * surface
            )
            condition = -(flux + heating) / SCALE_SURFACE
        parts.append((2 + self.count, 0, condition))
        return self._assemble(parts, jacobian)

    def heat_in(self, state: Array) -> tuple[float, float, float]:
        """Return heat conducted in, carried out by the gas and released by
        reactions, per mass [W/kg].
        """
        m = self.material
        T, masses, gas, surface = (_value(item) for item in self._fields(state))
        rates = self._rates(T, masses)
        made = self._made(T, rates)
        released = sum(
            -self.volume @ (rate * q) for rate, q in zip(rates, m.heat, strict=True)
        )
        gas_heat = m.gas_heat_capacity * (T - m.start)
        taken = self._enthalpy(T, made) - sum(made) * gas_heat
        released = released + self.volume @ taken
        carried = gas[-1] * m.gas_heat_capacity * (surface[0] - m.start)
        return (
            float(self.conductance(state) * (surface[0] - T[-1])),
            float(carried),
            float(released),
        )

    def conductance(self, state: Array) -> float:
        """Return the conductance between the surface and the outermost shell [W/kg/K]."""
        T, masses, *_ = (_value(item) for item in self._fields(state))
        m, outermost = self.material, self._conductivity(T, masses)[-1]
        return float(outermost * 2.0 / self.step * 3.0 / (m.radius * m.density))

    def _fields(
        self, state: Array, differentiate: bool = False
    ) -> tuple[Any, list[Any], Any, Any]:
        n, one = self.shells, np.ones(self.shells)
        values = state[:-1].reshape(-1, n)
        fields = [
            Dual(row, {(k, 0): one} if differentiate else {})
            for k, row in enumerate(values)
        ]
        surface = Dual(
            state[-1:], {(len(values), 0): np.ones(1)} if differentiate else {}
        )
        return fields[0], fields[1:-1], fields[-1], surface

    def _enthalpy(self, T: Any, amounts: Any) -> Any:
        """Return the enthalpy of amounts of the constituents above that at the
        start.
        """
        total: Any = 0.0
        capacity: Any = 0.0
        for amount, given in zip(amounts, self.material.heat_capacity, strict=True):
            if isinstance(given, float):
                capacity = capacity + amount * given
            else:
                total = total + amount * given(T)
        return capacity * (T - self.material.start) + total

    def _conductivity(self, T: Any, masses: Any) -> Any:
        """Return the conductivity in each shell [W/m/K], by what is left fresh."""
        m = self.material
        shares = zip(masses, m.fresh, strict=True)
        fresh, product = (k(T) for k in m.conductivity)
        share = sum(mass for mass, initial in shares if initial > 0.0)
        return product + share * (fresh - product)

    def _rates(self, T: Any, masses: Any) -> list[Any]:
        m = self.material
        return [
            A * np.exp(-E / T) * masses[k]
            for A, E, k in zip(m.rate, m.activation, m.reactant, strict=True)
        ]

    def _made(self, T: Any, rates: list[Any]) -> list[Any]:
        """Return omega of each constituent [1/s]."""
        return [
            sum((rate * y for rate, y in zip(rates, row, strict=True)), 0.0 * T)
            for row in self.material.change
        ]

    def _assemble(
        self, parts: list[tuple[int, int, Any]], jacobian: bool
    ) -> tuple[Array, Any]:
        """Sum values (entries,) into the rows of a block from a first shell on."""
        n, residual = self.shells, np.zeros(self.size)
        entries: list[tuple[Any, Any, Any]] = []
        for block, first, part in parts:
            rows = block * n + first + np.arange(len(part.value))
            residual[rows] += part.value
            if jacobian:
                for (field, offset), tangent in part.tangents.items():
                    columns = field * n + (
                        n - 1 if offset == OUTERMOST else np.arange(len(rows)) + offset
                    )
                    columns = np.broadcast_to(columns, len(rows))
                    kept = np.broadcast_to(tangent, len(rows))
                    entries.append((rows, np.maximum(columns, field * n), kept))
        if not jacobian:
            return residual, None
        row, column, value = (
            np.concatenate(part) for part in zip(*entries, strict=True)
        )
        return residual, sp.csc_matrix(
            (value, (row, column)), shape=(self.size, self.size)
        )


def _value(item: Any) -> Any:
    return [_value(each) for each in item] if isinstance(item, list) else item.value


def _cut(item: Dual, side: int) -> Dual:
    """Return a field at the shells inside (0) or outside (1) of all inner faces."""
    part = slice(0, -1) if side == 0 else slice(1, None)
    return Dual(
        item.value[part],
        {(k, side): tangent[part] for (k, _), tangent in item.tangents.items()},
    )


def _last(item: Dual) -> Dual:
    return Dual(
        item.value[-1:],
        {(k, OUTERMOST): tangent[-1:] for (k, _), tangent in item.tangents.items()},
    )


def _from_inside(item: Dual) -> Dual:
    """Return a field of the next shell inwards, 0 in the centre."""
    inner = np.ones(len(item.value))
    inner[0] = 0.0
    return Dual(
        np.append(0.0, item.value[:-1]), {(k, -1): inner for (k, _) in item.tangents}
    )
