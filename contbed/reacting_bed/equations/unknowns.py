"""Unknowns of a reacting bed: which there are and their names, and what follows from
them at a point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any, NamedTuple


class Role(Enum):
    """What an unknown is; T of gas and solids at once, where they share one."""

    GAS = "molar flux of a gas"
    SOLID = "moles of a constituent"
    T = "temperature"
    T_GAS = "temperature of the gas"
    T_SOLID = "temperature of a solid phase"
    PRESSURE = "pressure"
    FILM = "concentration at particles"
    POINT = "concentration at a point in particles"


TEMPERATURES = (Role.T, Role.T_GAS, Role.T_SOLID)
AMOUNTS = (Role.GAS, Role.SOLID, Role.POINT)  # which count the moles of a species


class Unknown(NamedTuple):
    """One unknown.

    species : gas, or constituent with the suffix of its phase; None of temperatures
        and pressure
    phase : solid phase that has it; None for the gas and the whole bed
    """

    name: str
    role: Role
    species: str | None = None
    phase: str | None = None

    @property
    def conserved(self) -> str | None:
        """The species whose moles it counts; None for temperatures, pressure and
        films.
        """
        return self.species if self.role in AMOUNTS else None

    @property
    def is_temperature(self) -> bool:
        """Whether it is a temperature."""
        return self.role in TEMPERATURES


# [K] below which properties are evaluated there, for states within an iteration
LEAST_T = 50.0


@dataclass(frozen=True)
class PhaseLayout:
    """Unknowns of one solid phase; its constituents that react and gases have their own
    names here.

    suffix : ends the names of its unknowns in a bed of several phases; "" for the only
        phase
    films : gases whose films around the particles are resolved
    inside : gases that are known at intraparticle `points`
    """

    name: str
    suffix: str = ""
    solids: tuple[str, ...] = ()
    films: tuple[str, ...] = ()
    inside: tuple[str, ...] = ()
    points: int = 0

    def full(self, name: str) -> str:
        """Return the name in the whole bed of a constituent, reaction or unknown of
        this phase.
        """
        return name + self.suffix

    @cached_property
    def temperature(self) -> str:
        """Name of the temperature of the phase, where it has its own."""
        return self.full("T_solid")

    @cached_property
    def inner(self) -> tuple[str, ...]:
        """Names of the intraparticle unknowns."""
        return tuple(name for points in self.of_points.values() for name in points)

    @cached_property
    def of_solids(self) -> dict[str, str]:
        """Unknown of each constituent."""
        return {name: self.full(f"n_{name}") for name in self.solids}

    @cached_property
    def of_films(self) -> dict[str, str]:
        """Unknown of the film of each gas."""
        return {name: self.full(f"s_{name}") for name in self.films}

    @cached_property
    def of_points(self) -> dict[str, list[str]]:
        """Unknowns of each gas at the points of a particle."""
        return {
            name: [self.full(f"a_{name}_{i}") for i in range(self.points)]
            for name in self.inside
        }


@dataclass(frozen=True)
class Layout:
    """Which unknowns there are, in their order; see `PhaseLayout` for those of solid
    phases.

    temperatures : (), ("T",) of gas and solids, or "T_fluid" and that of each solid
        phase
    pressure : whether it is an unknown
    """

    gases: tuple[str, ...]
    temperatures: tuple[str, ...]
    pressure: bool
    phases: tuple[PhaseLayout, ...] = ()

    @cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """All unknowns in their order."""
        owners = {phase.temperature: phase.name for phase in self.phases}
        roles = {"T": Role.T, "T_fluid": Role.T_GAS}
        found = [Unknown(f"g_{name}", Role.GAS, name) for name in self.gases]
        for phase in self.phases:
            for name, full in phase.of_solids.items():
                species = phase.full(name)
                found.append(Unknown(full, Role.SOLID, species, phase.name))
        for name in self.temperatures:
            role = roles.get(name, Role.T_SOLID)
            found.append(Unknown(name, role, None, owners.get(name)))
        if self.pressure:
            found.append(Unknown("p", Role.PRESSURE))
        for phase in self.phases:
            for name, full in phase.of_films.items():
                found.append(Unknown(full, Role.FILM, name, phase.name))
        for phase in self.phases:
            for name, points in phase.of_points.items():
                found += [
                    Unknown(each, Role.POINT, name, phase.name) for each in points
                ]
        return tuple(found)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all unknowns."""
        return tuple(each.name for each in self.unknowns)

    @cached_property
    def solids(self) -> tuple[str, ...]:
        """Constituents that react, with the suffix of their phase."""
        return tuple(phase.full(name) for phase in self.phases for name in phase.solids)

    @cached_property
    def films(self) -> dict[str, str]:
        """The gas of each film by the name of the film, "CO" of "CO_ore"."""
        return {phase.full(name): name for phase in self.phases for name in phase.films}

    @property
    def inside(self) -> tuple[str, ...]:
        """Intraparticle gases of any phase."""
        return tuple(
            dict.fromkeys(name for phase in self.phases for name in phase.inside)
        )

    @cached_property
    def owners(self) -> dict[str, str]:
        """The solid phase of each unknown that only one has."""
        return {
            each.name: each.phase for each in self.unknowns if each.phase is not None
        }


class State(NamedTuple):
    """What follows from the unknowns at points.

    n : moles of constituents that react [mol/m3 bed]
    T_solid : of the particles, of several phases the mean by volume
    moles, flux : molar and mass flux of the gas
    films : concentrations at the particles [mol/m3]
    inner : concentrations in the pores of particles, at their points
    phases : the state as each solid phase sees it, with the names of its own
        constituents and gases; of the only phase it is the state itself
    """

    g: Mapping[str, Any]
    n: Mapping[str, Any]
    T_fluid: Any
    T_solid: Any
    p: Any
    moles: Any
    flux: Any
    x: Mapping[str, Any]
    c: Mapping[str, Any]
    rho: Any
    films: Mapping[str, Any]
    inner: Mapping[str, Sequence[Any]]
    phases: Mapping[str, State]

    def of(self, phase: str | None) -> State:
        """Return the state as a solid phase sees it, None for the gas."""
        return self if phase is None else self.phases[phase]

    @property
    def u(self) -> Any:
        """Superficial velocity [m/s]."""
        return self.flux / self.rho
