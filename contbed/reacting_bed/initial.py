"""State at the start of a run from a table along the bed: profiles.csv of an earlier
run, or one written by hand.

    initial = { file = "earlier/profiles.csv", time = "300 s" }

    x [m], T_fluid [K], T_solid [K]       one of both holds for gas and particles; T_solid_PHASE of several
    x_GAS [1]                             all of them sum to 1; a gas without a column is not there
    n_SOLID [mol/m3] or w_SOLID [1]       moles per volume of bed; or mass fractions, at the mass per volume of bed with
                                          which the particles enter; SOLID_PHASE of several
    q_GAS [mol/kg]                        moles that particles hold per mass; q_GAS_PHASE of several

Between positions all is linear, beyond the first and the last it stays. What has no
column is uniform, or in equilibrium: temperatures by `initial.temperature`, the gas by
`initial.gas.composition`, solids as they enter, particles in equilibrium with the gas
around them. A file has means over the section and over particles: a bed with [section]
is uniform across, and particles with points inside are uniform there. Films, the
pressure and a gas that follows at once hold nothing and come from the equations. Solids
that do not react are there as they enter.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.equations.phase import Phase
from contbed.reacting_bed.equations.unknowns import LEAST_T, Role, State, Unknown
from contbed.reacting_bed.initial_rows import GAS, located, rows_of
from contbed.reacting_bed.inlet_series import SUM
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.results import constituents_of
from contbed.scene.names import nearest
from contbed.scene.profile import Rows

PER_VOLUME, PER_MASS = "mol/m**3", "mol/kg"
# share of the whole below zero that states of runs have, and that is taken as none
ROUNDED = 1e-6
# share by which temperatures may lie beyond the data of species, as results allow
WARM = 1e-3
# columns of profiles.csv that follow from others
OF_RESULTS = re.compile(r"t|u|p_gas|T_.*_(axis|wall)")


@dataclass(frozen=True, eq=False)
class Profile:
    """What a file says of the start, each along its rows; see the module for what is
    missing.

    temperatures : by unknown [K]
    fractions : mole fractions of all gases
    amounts : of solids that react [mol/m3 bed]
    inner : concentrations in the pores of particles [mol/m3] by gas and solid phase
    """

    rows: Rows
    temperatures: Mapping[str, Array] = field(default_factory=dict)
    fractions: Mapping[str, Array] = field(default_factory=dict)
    amounts: Mapping[str, Array] = field(default_factory=dict)
    inner: Mapping[tuple[str, str], Array] = field(default_factory=dict)

    def fill(self, problem: Problem, u: Array) -> None:
        """Replace what the file says in a state (m, N, p + 1)."""
        moles = problem.streams.moles
        for k, each in enumerate(problem.unknowns):
            found: Any = self.temperatures.get(each.name, self.amounts.get(each.name))
            if each.role is Role.GAS and self.fractions:
                found = self.fractions[str(each.species)] * moles
            elif each.role is Role.POINT:
                found = self.inside(each)
            if found is not None:
                u[k] = np.interp(problem.line.points, self.rows.where, found)

    def inside(self, unknown: Unknown) -> Array | None:
        """Return an intraparticle unknown along the rows; None where the file does
        not say.
        """
        return self.inner.get((str(unknown.species), str(unknown.phase)))

    def described(self, problem: Problem, stores_gas: bool) -> str:
        """Return what the file gives, and what else the run begins with."""
        layout, scene = problem.layout, problem.scene
        given = [
            *self.temperatures,
            *(f"x_{name}" for name in self.fractions),
            *self.amounts,
        ]
        given += [
            problem.species.phases[phase].full(f"q_{gas}") for gas, phase in self.inner
        ]
        time = "" if self.rows.time is None else f" at t = {self.rows.time:g} s"
        rest = []
        if layout.temperatures and not self.temperatures:
            rest.append("one temperature")
        if not (stores_gas or scene.adsorbs):
            rest.append("mole fractions have no effect, as the gas follows at once")
        elif not self.fractions:
            rest.append("gas of one composition")
        if layout.solids and not self.amounts:
            rest.append("solids as they enter")
        if scene.adsorbs and not self.inner:
            rest.append("particles in equilibrium with the gas around them")
        elif any(phase.layout.points > 1 for phase in problem.bed.phases.values()):
            rest.append("particles uniform inside, with the loadings of the file")
        if problem.rings is not None:
            rest.append("uniform across the section")
        return f"{self.rows.table.path.name}{time}: {', '.join(given)}" + "".join(
            f"; {text}" for text in rest
        )


def profile_of(scene: s.ReactingScene, problem: Problem) -> Profile:
    """Return the state at the start that a scene takes from its file.

    Raises
    ------
    SceneError : the file cannot be used; the message has the file, the line and the
        column
    """
    try:
        return _Reader(
            scene, problem, rows_of(scene.initial, scene.origin.base)
        ).profile()
    except SceneError as error:
        raise located(scene, error) from None


def phases_of(problem: Problem) -> list[tuple[Phase, State]]:
    """Return each solid phase, and what enters as it sees it."""
    return problem.bed.with_states(problem.bed.state(problem.first_point()))


class _Reader:
    """Reads the rows of a file as the unknowns of a problem."""

    def __init__(self, scene: s.ReactingScene, problem: Problem, rows: Rows | None):
        assert rows is not None
        self.given, self.problem, self.rows = scene.initial, problem, rows
        self.phases = problem.layout.phases
        self.solids = list(constituents_of(problem).values())
        self.loadings = {
            (gas, phase.name): phase.full(f"q_{gas}")
            for phase in self.phases
            for gas in phase.inside
        }

    def profile(self) -> Profile:
        """Return what the rows say."""
        self._has_no_other_columns()
        temperatures = self._temperatures()
        inner = self._inner(temperatures)
        return Profile(
            self.rows, temperatures, self._fractions(), self._amounts(), inner
        )

    def _has(self, name: str) -> bool:
        return name in self.rows.table.names

    def _mistake(self, text: str) -> SceneError:
        """Return a mistake of the header."""
        return self.rows.table.error(self.rows.table.header_line, text)

    def _missing(self, name: str, why: str) -> SceneError:
        return self._mistake(f"no column '{name}'; {why}")

    def _shares(self, of: str, names: Iterable[str]) -> dict[str, Array]:
        """Return the columns of fractions, whose names begin alike."""
        return {
            name: self._not_negative(of + name, self.rows.column(of + name, "1"), 1.0)
            for name in names
            if self._has(of + name)
        }

    def _has_no_other_columns(self) -> None:
        problem = self.problem
        solids = [name for names in self.solids for name in names]
        known = ["T_fluid", "T_solid", *(phase.temperature for phase in self.phases)]
        known += [f"x_{name}" for name in problem.species.gases]
        known += [f"{of}_{name}" for name in solids for of in ("n", "w")] + [
            *self.loadings.values()
        ]
        for name, unit in zip(
            self.rows.table.names, self.rows.table.units, strict=True
        ):
            if name in (*known, self.rows.place) or OF_RESULTS.fullmatch(name):
                continue
            if name[:2] in (GAS, "n_", "w_", "q_") and not np.any(
                self.rows.column(name, unit or "1")
            ):
                continue  # what this scene does not have is nowhere in the file either
            text = (
                f"column '{name}': nothing in this scene; remove it, or "
                f"{nearest(name, known)}"
            )
            raise self._mistake(text)

    def _temperatures(self) -> dict[str, Array]:
        """Return the temperatures by unknown."""
        wanted = self.problem.layout.temperatures
        own_names = [phase.temperature for phase in self.phases if phase.suffix]
        there = [name for name in ("T_fluid", "T_solid", *own_names) if self._has(name)]
        values = {name: self._temperature(name) for name in there}
        if not there or not wanted:
            return {}
        if self.given.temperature is not None:
            text = (
                f"column '{there[0]}': temperatures stand in initial.temperature as "
                "well; remove one of both"
            )
            raise self._mistake(text)
        found = {}
        for name in wanted:
            own = (
                ("T_solid", "T_fluid")
                if name == "T"
                else (name, "T_solid")
                if name in own_names
                else (name,)
            )
            column = (
                there[0]
                if len(there) == 1
                else next((each for each in own if each in values), None)
            )
            if column is None:
                raise self._missing(
                    own[0],
                    f"the file has {', '.join(there)}; give it as well, or one for all",
                )
            found[name] = values[column]
        return found

    def _temperature(self, name: str) -> Array:
        T = self.rows.column(name, "K")
        high = max(item.T_range[1] for item in self.problem.species.all.values()) * (
            1.0 + WARM
        )
        for row, least, text in (
            (int(T.argmin()), LEAST_T, f"lies below {LEAST_T:g} K"),
            (
                int(T.argmax()),
                -high,
                f"lies above {high / (1.0 + WARM):g} K, where the data of all species "
                "end",
            ),
        ):
            if np.sign(least) * T[row] < least:
                advice = (
                    f"a temperature in degrees Celsius stands under '{name} [degC]'"
                )
                raise self.rows.error(
                    row, f"column '{name}': {T[row]:g} K {text}; {advice}"
                )
        return T

    def _not_negative(self, name: str, values: Array, whole: Array | float) -> Array:
        """Return values that are not below zero but for rounding."""
        low = values + ROUNDED * np.asarray(whole)
        if low.min() < 0.0:
            row = int(low.argmin())
            raise self.rows.error(
                row, f"column '{name}': {values[row]:.6g} is below zero; correct it"
            )
        found: Array = np.maximum(values, 0.0)
        return found

    def _sum_to_one(
        self, what: str, values: Iterable[Array], rest: float = 0.0
    ) -> Array:
        """Return the sums of fractions, which with a `rest` are one but for their
        digits.
        """
        total: Array = np.asarray(sum(values))
        wrong = np.abs(total + rest - 1.0)
        if wrong.max() > SUM:
            row = int(wrong.argmax())
            others = f", {rest:.6g} of them of what does not react" if rest else ""
            raise self.rows.error(
                row,
                f"{what} sum to {total[row] + rest:.6g}{others}; they must sum to 1",
            )
        return total

    def _fractions(self) -> dict[str, Array]:
        """Return the mole fractions of all gases."""
        gases = self.problem.species.gases
        given = self._shares(GAS, gases)
        if not given:
            return {}
        if self.given.gas.composition is not None:
            text = (
                f"column '{GAS}{next(iter(given))}': the gas stands in "
                "initial.gas.composition as well; remove one"
            )
            raise self._mistake(text)
        total = self._sum_to_one("mole fractions, x_GAS [1],", given.values())
        none = np.zeros_like(total)
        return {name: given[name] / total if name in given else none for name in gases}

    def _amounts(self) -> dict[str, Array]:
        """Return the moles of solids that react per volume of bed, by unknown."""
        found: dict[str, Array] = {}
        for names in self.solids:
            react = [name for name in names if name in self.problem.layout.solids]
            if any(self._has(f"n_{name}") for name in names):
                found |= self._by_moles(names, react)
            elif react and any(self._has(f"w_{name}") for name in names):
                found |= self._by_mass(names, react)
        return found

    def _by_moles(self, names: list[str], react: list[str]) -> dict[str, Array]:
        fed = self.problem.streams.solid
        for name in names:
            if name not in react and self._has(f"n_{name}"):
                self._is_as_fed(
                    f"n_{name}", self.rows.column(f"n_{name}", PER_VOLUME), fed[name]
                )
            elif name in react and not self._has(f"n_{name}"):
                raise self._missing(
                    f"n_{name}",
                    "give the moles of all solids that react, 0 of those not there",
                )
        n = {name: self.rows.column(f"n_{name}", PER_VOLUME) for name in react}
        whole = sum(np.abs(values) for values in n.values())
        return {
            f"n_{name}": self._not_negative(f"n_{name}", values, whole)
            for name, values in n.items()
        }

    def _by_mass(self, names: list[str], react: list[str]) -> dict[str, Array]:
        solids, fed = self.problem.species.solids, self.problem.streams.solid
        density = sum(fed[name] * solids[name].molar_mass for name in names)
        for name in names:
            if name not in react and self._has(f"w_{name}"):
                share = fed[name] * solids[name].molar_mass / density
                self._is_as_fed(f"w_{name}", self.rows.column(f"w_{name}", "1"), share)
        w = self._shares("w_", react)
        inert = (
            sum(
                fed[name] * solids[name].molar_mass
                for name in names
                if name not in react
            )
            / density
        )
        total = self._sum_to_one(
            "mass fractions, w_SOLID [1],", w.values(), float(inert)
        )
        none, scale = np.zeros_like(total), density * (1.0 - inert) / total
        return {
            f"n_{name}": w.get(name, none) * scale / solids[name].molar_mass
            for name in react
        }

    def _is_as_fed(self, column: str, values: Array, fed: float) -> None:
        wrong = np.abs(values - fed)
        if wrong.max() > SUM * max(fed, ROUNDED):
            row = int(wrong.argmax())
            text = (
                f"{values[row]:.6g}, and this solid does not react and is there as "
                f"it enters, {fed:.6g}"
            )
            raise self.rows.error(
                row, f"column '{column}': {text}; remove the column, or change [solids]"
            )

    def _inner(self, temperatures: Mapping[str, Array]) -> dict[tuple[str, str], Array]:
        """Return the concentrations in the pores of particles that hold the loadings
        of the file.
        """
        found: dict[tuple[str, str], Array] = {}
        for phase, own in phases_of(self.problem):
            name = phase.layout.name
            columns = {gas: self.loadings[gas, name] for gas in phase.layout.inside}
            if not any(self._has(column) for column in columns.values()):
                continue
            q = {}
            for gas, column in columns.items():
                if not self._has(column):
                    raise self._missing(
                        column, "give the loadings of all gases that are adsorbed"
                    )
                values = self.rows.column(column, PER_MASS)
                q[gas] = self._not_negative(column, values, float(np.abs(values).max()))
            T: Any = temperatures.get(phase.layout.temperature, temperatures.get("T"))
            if T is None:
                T = self.given.temperature or own.T_solid
            assert phase.inside is not None
            c = phase.inside.concentrations(q, T * np.ones_like(self.rows.where))
            for gas, values in c.items():
                if not np.isfinite(values).all():
                    row = int(np.flatnonzero(~np.isfinite(values))[0])
                    text = (
                        f"{q[gas][row]:.6g} mol/kg is no less than the capacity of "
                        "the particles"
                    )
                    raise self.rows.error(
                        row,
                        f"column '{columns[gas]}': {text}; see "
                        f"solids.{name}.adsorption.{gas}.capacity",
                    )
                found[gas, name] = values
        return found
