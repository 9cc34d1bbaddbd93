"""Unknowns of a reacting bed: which there are and their names, and what follows from them at a point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

LEAST_T = 50.0  # [K] below which properties are evaluated there, for states within an iteration


@dataclass(frozen=True)
class Layout:
    """Which unknowns there are, in their order."""

    gases: tuple[str, ...]
    solids: tuple[str, ...]
    temperatures: tuple[str, ...]  # (), ("T",) or ("T_fluid", "T_solid")
    pressure: bool
    films: tuple[str, ...] = ()
    inside: tuple[str, ...] = ()  # gases inside of particles
    points: int = 0  # of a particle, at which they are known
    kinds: tuple[str, ...] = ()  # of particles where there are several, whose names end those of solids and films
    inside_kinds: tuple[str, ...] = ()  # unknowns inside of several kinds of particles

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all unknowns."""
        pressure = ("p",) if self.pressure else ()
        gases, films = (f"g_{name}" for name in self.gases), (f"s_{name}" for name in self.films)
        solids = (f"n_{name}" for name in self.solids)
        return (*gases, *solids, *self.temperatures, *pressure, *films, *self.inner, *self.inside_kinds)

    @cached_property
    def inner(self) -> tuple[str, ...]:
        """Names of the unknowns inside of particles of one kind."""
        return tuple(f"a_{name}_{i}" for name in self.inside for i in range(self.points))

    def concentrations(self, values: Mapping[str, Any]) -> dict[str, list[Any]]:
        """Return the concentrations of each gas at the points of a particle, from unknowns by name."""
        return {name: [values[f"a_{name}_{i}"] for i in range(self.points)] for name in self.inside}

    def gas_of_film(self, film: str) -> str:
        """Return the gas of a film, "CO" of that of the kind "ore", "CO_ore"."""
        return film.rpartition("_")[0] if self.kinds else film


def conserved(name: str) -> str | None:
    """Return the species whose moles an unknown counts; None for temperatures, pressure and films."""
    kind, _, rest = name.partition("_")
    if kind == "a":  # a_GAS_POINT, or a_GAS_POINT_KIND
        gas, _, last = rest.rpartition("_")
        return gas if last.isdigit() else gas.rpartition("_")[0]
    return rest if kind in ("g", "n") else None


@dataclass(frozen=True)
class State:
    """What follows from the unknowns at points."""

    g: Mapping[str, Any]
    n: Mapping[str, Any]
    T_fluid: Any
    T_solid: Any
    p: Any
    moles: Any  # molar flux of the gas
    flux: Any  # mass flux
    x: Mapping[str, Any]
    c: Mapping[str, Any]
    rho: Any
    films: Mapping[str, Any] = field(default_factory=dict)  # concentrations at the particle [mol/m3]
    inner: Mapping[str, Sequence[Any]] = field(default_factory=dict)  # in the pores of particles, at their points
    kinds: Mapping[str, State] = field(default_factory=dict)  # as each of several kinds of particles sees it

    def of(self, kind: str | None) -> State:
        """Return the state as a kind of particles sees it, None where there is one."""
        return self if kind is None else self.kinds[kind]

    @property
    def u(self) -> Any:
        """Superficial velocity [m/s]."""
        return self.flux / self.rho
