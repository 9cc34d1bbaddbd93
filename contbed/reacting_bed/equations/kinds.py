"""Several kinds of particles in one bed: the gas passes them all, each has its own constituents and temperature.

    solid j of kind i   d/dx [ v_i n_ij ] = S_ij                                       n_ij [mol/m3 bed]
    kind i              d/dx [ v_i sum_j n_ij h_j(T_i) - s_i K_s(T_i) T_i' ] = -h_i a_i (T_i - T_f) - X_i
    species k           d/dx [ g_k + J_k/M_k ] = S_k,gas + sum_i S_k,i
    gas                 d/dx [ sum (g_k + J_k/M_k) h_k(T_f) - K_f T_f' ] = sum_i ( h_i a_i (T_i - T_f) + X_i ) + q_w
    film of kind i      0 = k_f,k,i a_i (c_k - c_s,k,i) + S_k,i
    inside of kind i    gas in the pores and adsorbed by its own isotherms, see `equations.inside`

with s_i the share of kind i in the volume of the particles, a_i = 6 s_i (1 - eps)/d_i, films and Nusselt numbers on d_i
and the velocity relative to it. Kinds exchange heat and species by the gas alone. Each conducts by its share, along
and across, as a bed filled with it would. With one temperature all energy equations are added. The resistance to flow
is that of spheres of the Sauter mean 1/sum(s_i/d_i), on the velocity relative to the mean of the particles by volume.

Of the equations those of one kind are those of `equations.bed`, with the gas that all share.

Source: Kunii, Levenspiel 1991, Fluidization Engineering, 2nd ed., ch. 3 for the mean diameter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.reacting_bed.equations.bed import Bed
from contbed.reacting_bed.equations.unknowns import Layout, State


def of_kind(name: str, kind: str) -> str:
    """Return the name that an unknown, species or reaction of a kind has in the whole bed."""
    return f"{name}_{kind}"


def _of_gas(state: State) -> State:
    """Return the state without particles."""
    return replace(state, n={}, films={})


@dataclass(frozen=True, eq=False)
class KindsBed(Bed):
    """The equations of a bed with several kinds of particles; `parts` are those of each kind alone with the gas."""

    parts: Mapping[str, Bed] = field(default_factory=dict)

    @cached_property
    def gas(self) -> Bed:
        """The equations of the gas alone."""
        temperatures = self.layout.temperatures and (
            ("T",) if "T" in self.layout.temperatures else ("T_fluid", "T_solid")
        )
        layout = Layout(self.layout.gases, (), temperatures, self.layout.pressure)
        reactions = [reaction for reaction in self.reactions if reaction.kind is None]
        return Bed(
            layout,
            self.masses,
            self.enthalpies,
            reactions,
            self.medium,
            0.0,
            (),
            self.p_in,
            self.T_in,
            self.strength,
            self.small,
        )

    @cached_property
    def beds(self) -> dict[str, Bed]:
        """The equations of each kind with the rates of this bed."""
        found = {}
        for kind, part in self.parts.items():
            most = {name: self.most_lost[of_kind(name, kind)] for name in part.layout.solids if self.most_lost}
            found[kind] = replace(part, strength=self.strength, small=self.small, most_lost=most)
        return found

    @cached_property
    def names_of(self) -> dict[str, tuple[str, ...]]:
        """Names in the whole bed of the unknowns of each kind."""
        return {
            kind: tuple(
                name if name.startswith("g_") or name in ("T", "T_fluid") else of_kind(name, kind)
                for name in part.layout.names
            )
            for kind, part in self.parts.items()
        }

    @cached_property
    def _kind_of(self) -> dict[str, str]:
        """Kind of each unknown that only one has."""
        gas = set(self.gas.layout.names)
        return {name: kind for kind, names in self.names_of.items() for name in names if name not in gas}

    def state(self, u: Sequence[Any]) -> State:
        """Return the state at points from the unknowns; the temperature of the particles is the mean by volume."""
        values = dict(zip(self.layout.names, u, strict=True))
        if len(self.layout.temperatures) > 1:
            values["T_solid"] = sum(
                part.medium.share * values[of_kind("T_solid", kind)] for kind, part in self.parts.items()
            )
        at = self.gas.state([values[name] for name in self.gas.layout.names])
        kinds: dict[str, State] = {}
        n: dict[str, Any] = {}
        films: dict[str, Any] = {}
        for kind, part in self.parts.items():
            own = dict(zip(part.layout.names, (values[name] for name in self.names_of[kind]), strict=True))
            layout = part.layout
            kinds[kind] = replace(
                at,
                n={name: own[f"n_{name}"] for name in layout.solids},
                T_solid=own.get("T_solid", at.T_solid),
                films={name: own[f"s_{name}"] for name in layout.films},
                inner=layout.concentrations(own),
            )
            n |= {of_kind(name, kind): value for name, value in kinds[kind].n.items()}
            films |= {of_kind(name, kind): value for name, value in kinds[kind].films.items()}
        return replace(at, n=n, films=films, kinds=kinds)

    def _in_order(self, found: Mapping[str, Any]) -> list[Any]:
        return [found.get(name, 0.0) for name in self.layout.names]

    def _convective(self, state: State, h: Mapping[str, Any]) -> list[Any]:
        found = dict(zip(self.gas.layout.names, self.gas._convective(_of_gas(state), h), strict=True))
        for kind, part in self.beds.items():
            own, v = state.kinds[kind], part.velocity_solid
            if not v:
                continue
            found |= {of_kind(f"n_{name}", kind): v * n for name, n in own.n.items()}
            inner = zip(part.layout.inner, part.held_inside(own), strict=True)
            found |= {of_kind(name, kind): v * held for name, held in inner}
            if "T" in found:
                found["T"] = found["T"] + v * part.held_by_solids(own)
            elif self.layout.temperatures:
                found[of_kind("T_solid", kind)] = v * part.held_by_solids(own)
        return self._in_order(found)

    def _diffusive(self, state: State, q: Sequence[Any], transport: Any, h: Mapping[str, Any]) -> list[Any]:
        slopes = {"T_solid": 0.0, **dict(zip(self.layout.names, q, strict=True))}
        names = self.gas.layout.names
        found = dict(
            zip(names, self.gas._diffusive(_of_gas(state), [slopes[name] for name in names], transport, h), strict=True)
        )
        if len(self.layout.temperatures) > 1:
            for kind, own in transport.kinds.items():
                name = of_kind("T_solid", kind)
                found[name] = -own.conductivity_solid * slopes[name]
        return self._in_order(found)

    def _damped(self, state: State, J: Mapping[str, Any]) -> list[Any]:
        gas, heat = self._gas_damped(state, J)
        found = {f"g_{name}": flux for name, flux in gas.items()}
        found |= dict.fromkeys(("T", "T_fluid"), heat)
        for kind, part in self.parts.items():
            own = {of_kind(f"n_{name}", kind): name for name in part.layout.solids}
            found |= {name: J[name] for name in own}
            T = state.kinds[kind].T_solid
            if self.layout.temperatures:
                carried: Any = sum(J[name] * part.enthalpies[solid](T) for name, solid in own.items())
                found["T"] = found["T"] + carried
                found[of_kind("T_solid", kind)] = carried
        return self._in_order(found)

    def _sources(self, state: State, transport: Any, h: Mapping[str, Any]) -> list[Any]:
        found = dict(zip(self.gas.layout.names, self.gas._sources(_of_gas(state), transport, h), strict=True))
        for kind, part in self.beds.items():
            own = part._sources(state.kinds[kind], transport.kinds[kind], h)
            for name, source in zip(self.names_of[kind], own, strict=True):
                found[name] = found[name] + source if name in found else source
        return self._in_order(found)

    def coupling(self) -> NDArray[np.float64] | None:
        """Return the sources that are linear in the unknowns (m, m): diffusion between points inside of each kind."""
        parts = {kind: part.coupling() for kind, part in self.parts.items()}
        if all(part is None for part in parts.values()):
            return None
        out = np.zeros((len(self.layout.names), len(self.layout.names)))
        for kind, part in parts.items():
            if part is not None:
                here = [self.layout.names.index(name) for name in self.names_of[kind]]
                out[np.ix_(here, here)] += part
        return out

    def held_inside(self, state: State) -> list[Any]:
        """Return the moles that each point of particles holds of each gas, as the unknowns are ordered [mol/m3 bed]."""
        return [moles for part, own in self.phases(state) for moles in part.held_inside(own)]

    def rates(self, state: State, transport: Any) -> list[Any]:
        """Return the rates of all reactions [mol/m3 bed/s]."""
        places = [(self.gas, state, transport)]
        places += [(bed, state.kinds[kind], transport.kinds[kind]) for kind, bed in self.beds.items()]
        found: dict[str, Any] = {}
        for bed, at, coefficients in places:
            if bed.reactions:
                names = (reaction.name for reaction in bed.reactions)
                found.update(zip(names, bed.rates(at, coefficients), strict=True))
        return [found[reaction.name] for reaction in self.reactions]

    def held_by_solids(self, state: State) -> Any:
        """Return the enthalpy of all solids [J/m3 bed]."""
        return sum(part.held_by_solids(own) for part, own in self.phases(state))

    def heat_held(self, state: State, name: str) -> Any:
        """Return the enthalpy of the solids in the balance of a temperature [J/m3 bed]."""
        if name not in self._kind_of:
            return self.held_by_solids(state)
        kind = self._kind_of[name]
        return self.parts[kind].held_by_solids(state.kinds[kind])

    def knows_heat(self, name: str) -> bool:
        """Whether solids with data stand in the balance of a temperature."""
        kinds = [self._kind_of[name]] if name in self._kind_of else self.parts
        return any(self.parts[kind].knows_heat(name) for kind in kinds)

    def velocity_of(self, name: str) -> float:
        """Return the true velocity of the solids that an unknown belongs to [m/s]."""
        return self.parts[self._kind_of[name]].velocity_solid if name in self._kind_of else self.velocity_solid

    def phases(self, state: State) -> list[tuple[Bed, State]]:
        """Return the bed of each kind of particles, and the state as it sees it."""
        return [(part, state.kinds[kind]) for kind, part in self.beds.items()]
