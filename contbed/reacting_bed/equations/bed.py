"""Gas species, solids, one or two temperatures and the pressure along a packed or moving bed.

    species k     d/dx [ g_k + J_k/M_k ] = S_k                                  g_k molar flux of convection [mol/m2/s]
    solid j       d/dx [ v_s n_j ] = S_j                                        n_j [mol/m3 bed]
    gas           d/dx [ sum (g_k + J_k/M_k) h_k(T_f) - K_f T_f' ] = h a (T_s - T_f) + X + q_w
    solid         d/dx [ v_s sum n_j h_j(T_s) - K_s T_s' ] = -h a (T_s - T_f) - X
    pressure      d/dx p = -mu U/K - c_F rho |U| U/sqrt(K)
    film          0 = k_f,k a (c_k - c_s,k) + S_k,s
    inside        d/dx [ v_s m_k,i ] = what point i of the particles gains of gas k, see `equations.inside`; what it
                  gains from other points is linear and constant, and stands in `Bed.coupling`; reactions there add
                  w_i S_k(c_i)

Superficial fluxes: G = sum M_k g_k, u = G/rho, U = u - eps u_s/(1 - eps) relative to the particles, v_s = u_s/(1-eps).
Enthalpies contain heats of formation, so that no heat of reaction appears anywhere. What particles make leaves them at
T_s, what they take comes at T_f:

    X = sum_k ( S_k,s+ h_k(T_s) - S_k,s- h_k(T_f) )       S_k,s the part of particles and catalyst, + what is made

    J_k = -eps rho ( D_k w_k' - w_k sum_j D_j w_j' )

The correction makes the J_k sum to zero. The weighted sum of all species equations is that of G. With one temperature
both energy equations are added. Where species are no unknowns of a film the gas at the particle is that of the stream.
Several kinds of particles each have equations of their own, see `equations.kinds`; how amounts stay above zero tell
`limited` and `bounded`.

Source: Wakao, Kaguei 1982, Heat and Mass Transfer in Packed Beds; Bird, Stewart, Lightfoot 2002, ch. 19.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.closures.reactions import R_GAS
from contbed.reacting_bed.equations.inside import Inside
from contbed.reacting_bed.equations.losses import within
from contbed.reacting_bed.equations.unknowns import LEAST_T, Layout, State

Enthalpy = Callable[[Any], Any]


@dataclass(frozen=True, eq=False)
class Bed:
    """The equations of one bed.

    `medium` gives the coefficients of a state: exchange [W/m3/K], conductivities [W/m/K], dispersion [m2/s], the
    pressure gradient [Pa/m] and coefficients of films [m/s]; `inert` holds (n [mol/m3 bed], h) of what does not react.
    """

    layout: Layout
    masses: Mapping[str, float]
    enthalpies: Mapping[str, Enthalpy]
    reactions: Sequence[Any]
    medium: Any
    velocity_solid: float  # true velocity v_s [m/s]
    inert: tuple[tuple[float, Enthalpy], ...]
    p_in: float
    T_in: float
    strength: float = 1.0  # factor of all rates
    small: Any = None  # `local.Smoothing` of powers between 0 and 1; None: that of the laws
    gas_pressure: Any = None  # [Pa] at the nodes, at which the gas is stored in time; None: it follows at once
    inside: Inside | None = None  # particles that take up gas
    most_lost: Mapping[str, Any] = field(default_factory=dict)  # of solids at rest, see `losses` [mol/m3 bed/s]

    def state(self, u: Sequence[Any]) -> State:
        """Return the state at points from the unknowns."""
        layout = self.layout
        values = dict(zip(layout.names, u, strict=True))
        g = {name: values[f"g_{name}"] for name in layout.gases}
        T_fluid = values.get("T_fluid", values.get("T", self.T_in))
        T_solid = values.get("T_solid", values.get("T", self.T_in))
        p = values.get("p", self.p_in)
        moles: Any = sum(g.values())
        flux: Any = sum(self.masses[name] * g_k for name, g_k in g.items())
        molar = p / (R_GAS * np.maximum(T_fluid, LEAST_T))
        x = {name: g_k / moles for name, g_k in g.items()}
        c = {name: x_k * molar for name, x_k in x.items()}
        films = {name: values[f"s_{name}"] for name in layout.films}
        n = {name: values[f"n_{name}"] for name in layout.solids}
        inner = layout.concentrations(values)
        return State(g, n, T_fluid, T_solid, p, moles, flux, x, c, molar * flux / moles, films, inner)

    def __call__(self, u: Sequence[Any], q: Sequence[Any], _: Any) -> tuple[list[Any], list[Any], list[Any]]:
        """Return convective fluxes, diffusive fluxes and sources of all equations at points."""
        state = self.state(u)
        transport, h = self.medium.at(state), self._gas_enthalpies(state)
        return (
            self._convective(state, h),
            self._diffusive(state, q, transport, h),
            self._sources(state, transport, h),
        )

    def convective(self, u: Sequence[Any]) -> list[Any]:
        """Return the convective fluxes of all equations at points."""
        state = self.state(u)
        return self._convective(state, self._gas_enthalpies(state))

    def diffusive(self, u: Sequence[Any], q: Sequence[Any]) -> list[Any]:
        """Return the diffusive fluxes of all equations at points."""
        state = self.state(u)
        return self._diffusive(state, q, self.medium.at(state), self._gas_enthalpies(state))

    def damped(self, u: Sequence[Any], J: Sequence[Any]) -> list[Any]:
        """Return the fluxes of all equations that come with those of gases and solids which damp them in their cells.

        They carry their enthalpies. Where the gas fills the pores as many moles go back, of each gas its share.
        """
        return self._damped(self.state(u), dict(zip(self.layout.names, J, strict=True)))

    def _damped(self, state: State, J: Mapping[str, Any]) -> list[Any]:
        gas, heat = self._gas_damped(state, J)
        solids = {name: J[f"n_{name}"] for name in state.n}
        out = [*gas.values(), *solids.values()]
        if self.layout.temperatures:
            of_solids: Any = sum(flux * self.enthalpies[name](state.T_solid) for name, flux in solids.items())
            out += [heat + of_solids] if len(self.layout.temperatures) == 1 else [heat, of_solids]
        return out + [0.0] * (len(self.layout.names) - len(out))

    def _gas_damped(self, state: State, J: Mapping[str, Any]) -> tuple[dict[str, Any], Any]:
        """Return the fluxes of all gases that come with those which damp them, and of their heat."""
        fluxes = {name: J[f"g_{name}"] for name in state.g}
        if self.gas_pressure is not None:
            total: Any = sum(fluxes.values())
            fluxes = {name: flux - state.x[name] * total for name, flux in fluxes.items()}
        h = self._gas_enthalpies(state)
        return fluxes, sum(flux * h[name] for name, flux in fluxes.items()) if h else 0.0

    def _gas_enthalpies(self, state: State) -> dict[str, Any]:
        if not self.layout.temperatures:
            return {}
        return {name: self.enthalpies[name](state.T_fluid) for name in state.g}

    def _convective(self, state: State, h: Mapping[str, Any]) -> list[Any]:
        out = [*state.g.values(), *(self.velocity_solid * n for n in state.n.values())]
        temperatures = self.layout.temperatures
        if temperatures:
            gas: Any = sum(g * h[name] for name, g in state.g.items())
            solid = self.velocity_solid * self.held_by_solids(state) if self.velocity_solid else 0.0
            out += [gas + solid] if len(temperatures) == 1 else [gas, solid]
        if self.layout.pressure:
            out.append(state.p)
        out += [0.0] * len(self.layout.films)
        if self.inside is not None:
            moves = self.velocity_solid != 0.0
            inner = len(self.layout.inner)
            out += [self.velocity_solid * m for m in self.held_inside(state)] if moves else [0.0] * inner
        return out

    def _diffusive(self, state: State, q: Sequence[Any], transport: Any, h: Mapping[str, Any]) -> list[Any]:
        slopes = dict(zip(self.layout.names, q, strict=True))
        J = self.diffusion(state, slopes, transport)
        out = [*(J.get(name, 0.0) for name in state.g), *(0.0 for _ in state.n)]
        temperatures = self.layout.temperatures
        if temperatures:
            carried: Any = sum(flux * h[name] for name, flux in J.items()) if J else 0.0
            K_f, K_s = transport.conductivity_fluid, transport.conductivity_solid
            if len(temperatures) == 1:
                out.append(carried - (K_f + K_s) * slopes["T"])
            else:
                out += [carried - K_f * slopes["T_fluid"], -K_s * slopes["T_solid"]]
        return out + [0.0] * (len(self.layout.names) - len(out))

    def _sources(self, state: State, transport: Any, h: Mapping[str, Any]) -> list[Any]:
        made, by_particles, inside = self.made(state, transport)
        gains = self._taken_up(state, transport, made, by_particles, inside)
        out = [made.get(name, 0.0) for name in (*state.g, *state.n)]
        temperatures = self.layout.temperatures
        if len(temperatures) == 1:
            out.append(transport.wall)
        elif temperatures:
            X: Any = 0.0
            for name, rate in by_particles.items():
                leaves = getattr(rate, "value", rate) > 0.0
                X = X + rate * np.where(leaves, self.enthalpies[name](state.T_solid), h[name])
            passed = transport.exchange * (state.T_solid - state.T_fluid) + X
            out += [passed + transport.wall, -passed]
        if self.layout.pressure:
            out.append(-transport.pressure_gradient)
        for name in self.layout.films:
            through = transport.films[name] * self.medium.area * (state.c[name] - state.films[name])
            out.append(through + by_particles.get(name, 0.0))
        return out + gains

    def _taken_up(
        self,
        state: State,
        transport: Any,
        made: dict[str, Any],
        by_particles: dict[str, Any],
        inside: Mapping[str, Sequence[Any]],
    ) -> list[Any]:
        """Return what points of particles gain by reactions and, at the surface, through films from the gas."""
        if self.inside is None:
            return []
        gains: list[Any] = []
        for name, moles in self.inside.taken(state.inner, state.c, transport.films).items():
            made[name] = made.get(name, 0.0) - moles
            by_particles[name] = by_particles.get(name, 0.0) - moles
            at_points = list(inside.get(name, [0.0] * self.layout.points))
            gains += [*at_points[:-1], at_points[-1] + moles]
        return gains

    def coupling(self) -> NDArray[np.float64] | None:
        """Return the sources that are linear in the unknowns (m, m): diffusion between points inside of particles."""
        if self.inside is None or self.layout.points == 1:
            return None
        names, points = self.layout.names, self.layout.points
        out = np.zeros((len(names), len(names)))
        for gas in self.layout.inside:
            first = names.index(f"a_{gas}_0")
            here = slice(first, first + points)
            out[here, here] = self.inside.conduction(gas)
        return out

    def diffusion(self, state: State, slopes: Mapping[str, Any], transport: Any) -> dict[str, Any]:
        """Return the molar fluxes of dispersion J_k/M_k [mol/m2/s]; empty without dispersion."""
        if transport.dispersion is None:
            return {}
        mass_slope: Any = sum(self.masses[name] * slopes[f"g_{name}"] for name in self.layout.gases)
        w = {name: self.masses[name] * g / state.flux for name, g in state.g.items()}
        dw = {
            name: (self.masses[name] * slopes[f"g_{name}"] - w[name] * mass_slope) / state.flux
            for name in self.layout.gases
        }
        D = transport.dispersion
        common: Any = sum(D[name] * dw[name] for name in w)
        hold = self.medium.porosity * state.rho
        return {name: -hold * (D[name] * dw[name] - w[name] * common) / self.masses[name] for name in w}

    def made(self, state: State, transport: Any) -> tuple[dict[str, Any], dict[str, Any], dict[str, list[Any]]]:
        """Return what all reactions make of each species, and what particles make of each gas [mol/m3 bed/s].

        Of gases that are adsorbed reactions in particles make nothing of the gas between them, but what points inside
        gain, the last return value.
        """
        made: dict[str, Any] = {}
        particles: dict[str, Any] = {}
        inside: dict[str, list[Any]] = {}
        found = within(self._rates_at_points(state, transport), self.reactions, self.most_lost)
        for reaction, rates in zip(self.reactions, found, strict=True):
            rate = sum(rates[1:], rates[0])
            held = self._adsorbed(reaction)
            for name, count in reaction.stoichiometry.items():
                if name in held:
                    before = inside.get(name, [0.0] * len(rates))
                    inside[name] = [a + count * b for a, b in zip(before, rates, strict=True)]
                    continue
                made[name] = made[name] + count * rate if name in made else count * rate
                if reaction.site != "gas" and name in state.g:
                    particles[name] = particles[name] + count * rate if name in particles else count * rate
        return made, particles, inside

    def _adsorbed(self, reaction: Any) -> frozenset[str]:
        """Return the gases that a reaction finds inside of the particles, which adsorb them; none elsewhere."""
        if self.inside is None or reaction.site == "gas" or reaction.own_film:
            return frozenset()
        return reaction.gases & frozenset(self.inside.gases)

    @property
    def reacts_inside(self) -> bool:
        """Whether gases react in the particles that adsorb them."""
        return any(self._adsorbed(reaction) for reaction in self.reactions)

    def rates(self, state: State, transport: Any) -> list[Any]:
        """Return the rates of all reactions [mol/m3 bed/s]."""
        return [sum(rates[1:], rates[0]) for rates in self._rates_at_points(state, transport)]

    def _rates_at_points(self, state: State, transport: Any) -> list[list[Any]]:
        """Return the rates of all reactions [mol/m3 bed/s], the parts of the points of particles where these adsorb."""
        found, steps = [], {}
        for reaction in self.reactions:
            if gases := self._adsorbed(reaction):
                found.append(self._rates_inside(state, transport, reaction, gases))
                continue
            if reaction.step is None:
                rate = reaction.rate(self.medium.local(state, transport, reaction, self.small))
            else:  # all steps of a law are found together
                if reaction.rate not in steps:
                    steps[reaction.rate] = reaction.rate(self.medium.local(state, transport, reaction, self.small))
                rate = steps[reaction.rate][reaction.step]
            found.append([self.strength * rate])
        return found

    def _rates_inside(self, state: State, transport: Any, reaction: Any, gases: frozenset[str]) -> list[Any]:
        """Return the parts of a rate at the points of particles, where adsorbed gases have their concentrations.

        Other gases are there as around the particles.
        """
        assert self.inside is not None
        parts = []
        for i, weight in enumerate(self.inside.weights):
            inner = {name: state.inner[name][i] for name in gases}
            local = self.medium.local(state, transport, reaction, self.small, inner)
            parts.append(self.strength * float(weight) * reaction.rate(local))
        return parts

    def held_by_solids(self, state: State) -> Any:
        """Return the enthalpy of the solids [J/m3 bed]."""
        T = state.T_solid
        total: Any = sum(n * self.enthalpies[name](T) for name, n in state.n.items())
        if self.inside is not None:
            held, heat = self.inside.held(state.inner, np.maximum(T, LEAST_T))
            total = total + heat + sum(sum(points) * self.enthalpies[name](T) for name, points in held.items())
        return total + sum(n * h(T) for n, h in self.inert)

    def heat_held(self, state: State, _: str) -> Any:
        """Return the enthalpy of the solids in the balance of a temperature [J/m3 bed]."""
        return self.held_by_solids(state)

    def knows_heat(self, _: str) -> bool:
        """Whether solids with data stand in the balance of a temperature."""
        return bool(self.inert or self.layout.solids)

    def velocity_of(self, _: str) -> float:
        """Return the true velocity of the solids that an unknown belongs to [m/s]."""
        return self.velocity_solid

    def phases(self, state: State) -> list[tuple[Bed, State]]:
        """Return the bed of each kind of particles, and the state as it sees it."""
        return [(self, state)]

    def held_inside(self, state: State) -> list[Any]:
        """Return the moles that each point of particles holds of each gas, as the unknowns are ordered [mol/m3 bed]."""
        if self.inside is None:
            return []
        held = self.inside.held(state.inner, np.maximum(state.T_solid, LEAST_T))[0]
        return [moles for points in held.values() for moles in points]

    def held_by_gas(self, state: State) -> tuple[dict[str, Any], Any]:
        """Return the moles of each gas in the pores, and their enthalpy [per m3 bed].

        The pressure is `gas_pressure`, constant in time: a flow and a pressure that are both given where the gas enters
        leave no freedom to store more by compression.
        """
        eps = self.medium.porosity
        molar = self.gas_pressure / (R_GAS * np.maximum(state.T_fluid, LEAST_T))
        held = {name: eps * molar * x for name, x in state.x.items()}
        if not self.layout.temperatures:
            return held, 0.0
        enthalpy: Any = sum(c * self.enthalpies[name](state.T_fluid) for name, c in held.items())
        return held, enthalpy
