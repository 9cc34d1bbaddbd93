"""Gas species, solid phases, temperatures and the pressure along a packed or moving
bed.

    species k           d/dx [ g_k + J_k/M_k ] = S_k                      g_k molar flux of convection [mol/m2/s]
    constituent j of i  d/dx [ v_i n_ij ] = S_ij                          n_ij [mol/m3 bed]
    gas                 d/dx [ sum (g_k + J_k/M_k) h_k(T_f) - K_f T_f' ] = sum_i ( h_i a_i (T_i - T_f) + X_i ) + q_w
    solid phase i       d/dx [ v_i sum_j n_ij h_j(T_i) - s_i K_s(T_i) T_i' ] = -h_i a_i (T_i - T_f) - X_i
    pressure            d/dx p = -mu U/K - c_F rho |U| U/sqrt(K)
    film of phase i     0 = k_f,ki a_i (c_k - c_s,ki) + S_ki
    inside of phase i   d/dx [ v_i m_k,l ] = what point l of the particles gains of gas k, see `equations.inside`;
                        what it gains from other points is linear and constant, and stands in `Bed.coupling`;
                        reactions there add w_l S_k(c_l)

Superficial fluxes: G = sum M_k g_k, u = G/rho, U = u - eps u_s/(1 - eps) relative to
the particles, v = u_s/(1 - eps). s_i is the share of phase i in the volume of the
particles, a_i = 6 s_i (1 - eps)/d_i; films and Nusselt numbers are on d_i and the
velocity relative to it. Phases exchange heat and species by the gas alone. Each
conducts by its share, along and across, as a bed filled with it would. The resistance
to flow is that of spheres of the Sauter mean 1/sum(s_i/d_i), on the velocity relative
to the mean of the particles by volume. Enthalpies contain heats of formation, so that
no heat of reaction appears anywhere. What particles make leaves them at T_i, what they
take comes at T_f:

    X_i = sum_k ( S_ki+ h_k(T_i) - S_ki- h_k(T_f) )       S_ki the part of particles and catalyst, + what is made

    J_k = -eps rho ( D_k w_k' - w_k sum_j D_j w_j' )

The correction makes the J_k sum to zero. The weighted sum of all species equations is
that of G. With one temperature all energy equations are added. Where species are no
unknowns of a film the gas at the particle is that of the stream. How amounts stay above
zero: `steady_positivity` and `positivity_in_time`.

Source: Wakao, Kaguei 1982, Heat and Mass Transfer in Packed Beds; Bird, Stewart,
    Lightfoot 2002, ch. 19; Kunii,
Levenspiel 1991, Fluidization Engineering, 2nd ed., ch. 3 for the mean diameter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.chemistry.kinetics import rates_of
from contbed.chemistry.sums import Sums
from contbed.chemistry.thermo import R_GAS
from contbed.reacting_bed.equations.consumption_limit import within
from contbed.reacting_bed.equations.phase import Enthalpy, Phase
from contbed.reacting_bed.equations.unknowns import LEAST_T, Layout, State

Amounts = Sums  # by species [mol/m3 bed/s]


@dataclass(frozen=True, eq=False)
class Bed:
    """The equations of one bed.

    medium : gives the coefficients of a state, see `medium.Medium`
    phases : solid phases by name
    strength : factor of all rates
    small : `local.Smoothing` of powers between 0 and 1; None: that of the laws
    gas_pressure : [Pa] at the nodes, at which the gas is stored in time; None: it
        follows at once
    most_lost : of solids at rest [mol/m3 bed/s], see
        `consumption_limit`
    """

    layout: Layout
    masses: Mapping[str, float]
    enthalpies: Mapping[str, Enthalpy]
    reactions: Sequence[Any]
    medium: Any
    phases: Mapping[str, Phase]
    p_in: float
    T_in: float
    strength: float = 1.0
    small: Any = None
    gas_pressure: Any = None
    most_lost: Mapping[str, Any] = field(default_factory=dict)

    def state(self, u: Sequence[Any]) -> State:
        """Return the state at points from the unknowns."""
        layout = self.layout
        values = dict(zip(layout.names, u, strict=True))
        g = dict(zip(layout.gases, u, strict=False))
        T = values.get("T", self.T_in)
        T_fluid = values.get("T_fluid", T)
        p = values.get("p", self.p_in)
        moles: Any = 0
        flux: Any = 0
        for name, g_k in g.items():
            moles = moles + g_k
            flux = flux + self.masses[name] * g_k
        molar = p / (R_GAS * np.maximum(T_fluid, LEAST_T))
        x = {name: g_k / moles for name, g_k in g.items()}
        c = {name: x_k * molar for name, x_k in x.items()}
        gas = (p, moles, flux, x, c, molar * flux / moles)
        phases: dict[str, State] = {}
        for phase in layout.phases:
            n = {name: values[full] for name, full in phase.of_solids.items()}
            films = {name: values[full] for name, full in phase.of_films.items()}
            inner = {
                name: [values[full] for full in points]
                for name, points in phase.of_points.items()
            }
            T_solid = values.get(phase.temperature, T)
            phases[phase.name] = State(
                g, n, T_fluid, T_solid, *gas, films, inner, phases
            )
        if len(phases) == 1:
            return phases[layout.phases[0].name]
        all_n = {name: values[f"n_{name}"] for name in layout.solids}
        all_films = {name: values[f"s_{name}"] for name in layout.films}
        mean = T
        if len(layout.temperatures) > 1:
            parts = [
                self.phases[name].medium.share * state.T_solid
                for name, state in phases.items()
            ]
            mean = sum(parts[1:], parts[0])
        return State(g, all_n, T_fluid, mean, *gas, all_films, {}, phases)

    def __call__(
        self, u: Sequence[Any], q: Sequence[Any], _: Any
    ) -> tuple[list[Any], list[Any], list[Any]]:
        """Return convective fluxes, diffusive fluxes and sources of all equations at
        points.
        """
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
        return self._diffusive(
            state, q, self.medium.at(state), self._gas_enthalpies(state)
        )

    def damped(self, u: Sequence[Any], J: Sequence[Any]) -> list[Any]:
        """Return the fluxes of all equations that come with those of gases and solids
        which damp them in their cells.

        They carry their enthalpies. Where the gas fills the pores as many moles go
        back, of each gas its share.
        """
        state = self.state(u)
        fluxes = dict(zip(self.layout.names, J, strict=True))
        gases, heat = self._damped_gases(state, fluxes)
        found = {f"g_{name}": flux for name, flux in gases.items()}
        found |= {f"n_{name}": fluxes[f"n_{name}"] for name in self.layout.solids}
        found |= dict.fromkeys(("T", "T_fluid"), heat)
        for phase in self.phases.values() if self.layout.temperatures else ():
            T, solids = state.phases[phase.layout.name].T_solid, phase.layout.solids
            carried: Any = sum(
                fluxes[phase.layout.full(f"n_{name}")] * phase.enthalpies[name](T)
                for name in solids
            )
            found["T"] = found["T"] + carried
            found[phase.layout.temperature] = carried
        return [found.get(name, 0.0) for name in self.layout.names]

    def _damped_gases(
        self, state: State, J: Mapping[str, Any]
    ) -> tuple[dict[str, Any], Any]:
        """Return the fluxes of all gases that come with those which damp them, and
        of their heat.
        """
        fluxes = {name: J[f"g_{name}"] for name in state.g}
        if self.gas_pressure is not None:
            total: Any = sum(fluxes.values())
            fluxes = {
                name: flux - state.x[name] * total for name, flux in fluxes.items()
            }
        h = self._gas_enthalpies(state)
        return fluxes, sum(
            flux * h[name] for name, flux in fluxes.items()
        ) if h else 0.0

    def _gas_enthalpies(self, state: State) -> dict[str, Any]:
        if not self.layout.temperatures:
            return {}
        return {name: self.enthalpies[name](state.T_fluid) for name in state.g}

    def _convective(self, state: State, h: Mapping[str, Any]) -> list[Any]:
        pairs = self.with_states(state)
        temperatures = self.layout.temperatures
        out = [
            *state.g.values(),
            *(phase.velocity * n for phase, own in pairs for n in own.n.values()),
        ]
        if temperatures:
            gas: Any = sum(g * h[name] for name, g in state.g.items())
            carried = [
                phase.velocity * phase.enthalpy(own) if phase.velocity else 0.0
                for phase, own in pairs
            ]
            out += [sum(carried, gas)] if len(temperatures) == 1 else [gas, *carried]
        if self.layout.pressure:
            out.append(state.p)
        out += [0.0] * len(self.layout.films)
        for phase, own in pairs:
            if phase.velocity:
                out += [phase.velocity * moles for moles in phase.moles_inside(own)]
            else:
                out += [0.0] * len(phase.layout.inner)
        return out

    def _diffusive(
        self, state: State, q: Sequence[Any], transport: Any, h: Mapping[str, Any]
    ) -> list[Any]:
        slopes = dict(zip(self.layout.names, q, strict=True))
        J = self.diffusion(state, slopes, transport)
        out = [*(J.get(name, 0.0) for name in state.g), *(0.0 for _ in state.n)]
        temperatures = self.layout.temperatures
        if temperatures:
            carried: Any = sum(flux * h[name] for name, flux in J.items()) if J else 0.0
            K_f = transport.conductivity_fluid
            K_s = [each.conductivity_solid for each in transport.phases.values()]
            if len(temperatures) == 1:
                out.append(carried - sum(K_s, K_f) * slopes["T"])
            else:
                out.append(carried - K_f * slopes["T_fluid"])
                out += [
                    -K * slopes[name]
                    for K, name in zip(K_s, temperatures[1:], strict=True)
                ]
        return out + [0.0] * (len(self.layout.names) - len(out))

    def _sources(self, state: State, transport: Any, h: Mapping[str, Any]) -> list[Any]:
        made, by_phase, inside = self.made(state, transport)
        gains: list[Any] = []
        for name in self.phases:
            gains += self._taken_up(name, state, transport, made, by_phase, inside)
        out = [made.get(name, 0.0) for name in (*state.g, *state.n)]
        temperatures = self.layout.temperatures
        if len(temperatures) == 1:
            out.append(transport.wall)
        elif temperatures:
            passed = [
                self._passed(name, state, transport, by_phase[name], h)
                for name in self.phases
            ]
            out += [
                sum(passed[1:], passed[0]) + transport.wall,
                *(-heat for heat in passed),
            ]
        if self.layout.pressure:
            out.append(-transport.pressure_gradient)
        for phase, own in self.with_states(state):
            films = transport.phases[phase.layout.name].films
            rates = by_phase[phase.layout.name]
            for gas in phase.layout.films:
                through = (
                    films[gas] * phase.medium.area * (state.c[gas] - own.films[gas])
                )
                out.append(through + rates.get(gas, 0.0))
        return out + gains

    def _passed(
        self,
        name: str,
        state: State,
        transport: Any,
        rates: Amounts,
        h: Mapping[str, Any],
    ) -> Any:
        """Return the heat that a solid phase gives to the gas [W/m3 bed]."""
        T, enthalpies = state.phases[name].T_solid, self.phases[name].enthalpies
        carried: Any = 0.0
        for gas, rate in rates.items():
            leaves: Any = np.asarray(getattr(rate, "value", rate)) > 0.0
            carried = carried + rate * np.where(leaves, enthalpies[gas](T), h[gas])
        return transport.phases[name].exchange * (T - state.T_fluid) + carried

    def _taken_up(
        self,
        name: str,
        state: State,
        transport: Any,
        made: Amounts,
        by_phase: Mapping[str, Amounts],
        inside: Mapping[str, Mapping[str, Sequence[Any]]],
    ) -> list[Any]:
        """Return what points of particles gain by reactions and, at the surface,
        through films from the gas.

        What the films take is subtracted from what is `made` of the gas.
        """
        phase = self.phases[name]
        if phase.inside is None:
            return []
        gains: list[Any] = []
        taken = phase.inside.taken(
            state.phases[name].inner, state.c, transport.phases[name].films
        )
        for gas, moles in taken.items():
            made.add(gas, -moles)
            by_phase[name].add(gas, -moles)
            at_points = list(inside[name].get(gas, [0.0] * phase.layout.points))
            gains += [*at_points[:-1], at_points[-1] + moles]
        return gains

    def coupling(self) -> NDArray[np.float64] | None:
        """Return the sources that are linear in the unknowns (m, m): diffusion
        between intraparticle points.
        """
        parts = {name: phase.diffusion_inside() for name, phase in self.phases.items()}
        if all(part is None for part in parts.values()):
            return None
        names = self.layout.names
        out = np.zeros((len(names), len(names)))
        for name, part in parts.items():
            if part is not None:
                here = [names.index(each) for each in self.phases[name].layout.inner]
                out[np.ix_(here, here)] = part
        return out

    def diffusion(
        self, state: State, slopes: Mapping[str, Any], transport: Any
    ) -> dict[str, Any]:
        """Return the molar fluxes of dispersion J_k/M_k [mol/m2/s]; empty without
        dispersion.
        """
        if transport.dispersion is None:
            return {}
        mass_slope: Any = sum(
            self.masses[name] * slopes[f"g_{name}"] for name in self.layout.gases
        )
        w = {name: self.masses[name] * g / state.flux for name, g in state.g.items()}
        dw = {
            name: (self.masses[name] * slopes[f"g_{name}"] - w[name] * mass_slope)
            / state.flux
            for name in self.layout.gases
        }
        D = transport.dispersion
        common: Any = sum(D[name] * dw[name] for name in w)
        hold = self.medium.porosity * state.rho
        return {
            name: -hold * (D[name] * dw[name] - w[name] * common) / self.masses[name]
            for name in w
        }

    def made(
        self, state: State, transport: Any
    ) -> tuple[Amounts, dict[str, Amounts], dict[str, dict[str, list[Any]]]]:
        """Return what all reactions make of each species, and what each solid phase
        makes of each gas.

        Of gases that are adsorbed reactions in particles make nothing of the gas
        between them, but what points inside gain, the last return value.
        """
        made = Sums()
        by_phase = {name: Sums() for name in self.phases}
        inside: dict[str, dict[str, list[Any]]] = {name: {} for name in self.phases}
        found = within(
            self._rates_at_points(state, transport), self.reactions, self.most_lost
        )
        for reaction, rates in zip(self.reactions, found, strict=True):
            rate = sum(rates[1:], rates[0])
            adsorbed = self._adsorbed(reaction)
            for name, count in reaction.stoichiometry.items():
                if name in adsorbed:
                    before = inside[reaction.phase].get(name, [0.0] * len(rates))
                    inside[reaction.phase][name] = [
                        a + count * b for a, b in zip(before, rates, strict=True)
                    ]
                    continue
                made.add(name, count * rate)
                if reaction.site != "gas" and name in state.g:
                    by_phase[reaction.phase].add(name, count * rate)
        return made, by_phase, inside

    def _adsorbed(self, reaction: Any) -> frozenset[str]:
        """Return the intraparticle gases of a reaction, which the particles adsorb;
        none elsewhere.
        """
        if reaction.site == "gas" or reaction.own_film:
            return frozenset()
        inside = self.phases[reaction.phase].inside
        return (
            frozenset() if inside is None else reaction.gases & frozenset(inside.gases)
        )

    def reacts_inside(self, phase: str) -> bool:
        """Whether gases react in the particles of a phase that adsorbs them."""
        return any(
            self._adsorbed(reaction)
            for reaction in self.reactions
            if reaction.phase == phase
        )

    def rates(self, state: State, transport: Any) -> list[Any]:
        """Return the rates of all reactions [mol/m3 bed/s]."""
        return [
            sum(rates[1:], rates[0])
            for rates in self._rates_at_points(state, transport)
        ]

    def _rates_at_points(self, state: State, transport: Any) -> list[list[Any]]:
        """Return the rates of all reactions [mol/m3 bed/s], the parts of the points
        of particles where these adsorb.
        """
        around = [each for each in self.reactions if not self._adsorbed(each)]
        rates = iter(rates_of(around, partial(self._local, state, transport)))
        found: list[list[Any]] = []
        for reaction in self.reactions:
            if gases := self._adsorbed(reaction):
                found.append(self._rates_inside(state, transport, reaction, gases))
            else:
                found.append([self.strength * next(rates)])
        return found

    def _local(
        self,
        state: State,
        transport: Any,
        reaction: Any,
        inner: Mapping[str, Any] | None = None,
    ) -> Any:
        """Return the state as a reaction sees it, in the gas or in the particles of
        its phase.
        """
        if reaction.phase is None:
            return self.medium.local(state, self.small)
        medium, own = self.phases[reaction.phase].medium, state.phases[reaction.phase]
        return medium.local(
            own, transport.phases[reaction.phase], reaction, self.small, inner
        )

    def _rates_inside(
        self, state: State, transport: Any, reaction: Any, gases: frozenset[str]
    ) -> list[Any]:
        """Return the parts of a rate at the points of particles, where adsorbed gases
        have their concentrations.

        Other gases are there as around the particles.
        """
        inside, own = self.phases[reaction.phase].inside, state.phases[reaction.phase]
        assert inside is not None
        parts = []
        for i, weight in enumerate(inside.weights):
            inner = {name: own.inner[name][i] for name in gases}
            at = partial(self._local, state, transport, inner=inner)
            rate = rates_of([reaction], at)[0]
            parts.append(self.strength * float(weight) * rate)
        return parts

    @property
    def velocity_solid(self) -> float:
        """True velocity of the slowest solid phase that moves, 0 where none
        does [m/s].
        """
        return min(
            (phase.velocity for phase in self.phases.values() if phase.velocity),
            key=abs,
            default=0.0,
        )

    def velocity_of(self, name: str) -> float:
        """Return the true velocity of the solids that an unknown belongs to [m/s]."""
        owner = self.layout.owners.get(name)
        return self.velocity_solid if owner is None else self.phases[owner].velocity

    def with_states(self, state: State) -> list[tuple[Phase, State]]:
        """Return each solid phase with the state as it sees it."""
        return [(phase, state.phases[name]) for name, phase in self.phases.items()]

    def heat_of_solids(self, state: State, phase: str | None) -> Any:
        """Return the enthalpy of a solid phase, None for all [J/m3 bed]; None where
        data are missing.
        """
        pairs = [
            pair
            for pair in self.with_states(state)
            if phase in (None, pair[0].layout.name)
        ]
        if not any(phase.stores_heat for phase, _ in pairs):
            return None
        held = [phase.enthalpy(own) for phase, own in pairs]
        return sum(held[1:], held[0])

    def held_by_gas(self, state: State) -> tuple[dict[str, Any], Any]:
        """Return the moles of each gas in the pores, and their enthalpy [per m3 bed].

        The pressure is `gas_pressure`, constant in time: a flow and a pressure that are
        both given where the gas enters leave no freedom to store more by compression.
        """
        eps = self.medium.porosity
        molar = self.gas_pressure / (R_GAS * np.maximum(state.T_fluid, LEAST_T))
        held = {name: eps * molar * x for name, x in state.x.items()}
        if not self.layout.temperatures:
            return held, 0.0
        enthalpy: Any = sum(
            c * self.enthalpies[name](state.T_fluid) for name, c in held.items()
        )
        return held, enthalpy
