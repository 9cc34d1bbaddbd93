"""What a rate law is: a function that turns the table of a reaction into its rate, and
what it needs for that.

The modules of `chemistry.laws` hold the laws. A new one is a new entry in a dictionary
`LAWS` there, or a new module with one. Packed and moving beds then find it by its name,
bubbling beds too if it needs no solid that reacts. The single particle has laws of its
own, of first order in mass (`single_particle/scene.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from contbed.chemistry.equation import Equation
from contbed.chemistry.local import Local, Rate
from contbed.chemistry.power_law import PowerLaw, product
from contbed.chemistry.species import Species
from contbed.chemistry.thermo import R_GAS, Equilibrium
from contbed.closures.formula import TINY, odd_power, power
from contbed.errors import SceneError
from contbed.scene.reactions import Reaction

BAR = 1e5  # [Pa]
# share of all gases; of the derivative of c (1 - Q/K), ten digits of sixteen are lost
TRACE = 1e-10
SI_OF_BASIS = {
    "catalyst": "mol/kg/s",
    "gas": "mol/m**3/s",
    "particle": "mol/m**3/s",
    "bed": "mol/m**3/s",
}


@dataclass(frozen=True)
class Case:
    """One reaction of a scene, as a rate law sees it.

    name : key in [reactions]
    table : its constants
    species : gases and solids of the place where it runs
    """

    name: str
    table: Reaction
    equation: Equation
    species: Species

    @property
    def basis(self) -> str:
        """Per what its rate is where its law does not say."""
        moles = self.equation.stoichiometry
        of_solids = any(name in self.species.solids for name in moles)
        at_particles = of_solids or self.table.surface is not None
        return self.table.basis or ("particle" if at_particles else "gas")

    @cached_property
    def gases(self) -> dict[str, float]:
        """Moles made of each gas."""
        return {
            name: n
            for name, n in self.equation.stoichiometry.items()
            if name in self.species.gases
        }

    @cached_property
    def orders(self) -> dict[str, float]:
        """Orders in species; where none are given the coefficients of gases on the
        left. That of 0 counts in what is used up, without which the rate ends.
        """
        if self.table.orders is not None:
            made = self.equation.stoichiometry
            given = self.table.orders.items()
            return {name: n for name, n in given if n or made.get(name, 0.0) < 0.0}
        left = self.equation.left.items()
        return {name: n for name, n in left if name in self.species.gases}

    @cached_property
    def equilibrium(self) -> Equilibrium:
        """Its equilibrium by the thermodynamics of its species.

        Raises
        ------
        SceneError : a species has no entropy, and no factor makes up for it
        """
        missing = [
            name
            for name in self.equation.stoichiometry
            if not self.species.all[name].has_entropy
        ]
        if missing and self.table.equilibrium_factor == 1.0:
            raise SceneError(
                f"reactions.{self.name}: the equilibrium of '{self.table.equation}' needs "
                f"enthalpy and entropy of {' and '.join(missing)}; give them, or '->'"
            )
        return Equilibrium(
            self.equation.stoichiometry,
            self.species.all,
            frozenset(self.species.gases),
            self.table.equilibrium_factor,
        )

    def equilibrium_constant(self, T: Any) -> Any:
        """Return K in concentrations of gases [mol/m3], to the power that the
        equation asks for.
        """
        moles = sum(self.gases.values())
        return np.exp(self.equilibrium.ln_K(T)) * (BAR / (R_GAS * T)) ** moles

    def quotient(self, at: Local) -> Any:
        """Return Q/K: the gases made over those used up, each to its number in the
        equation, over this ratio in equilibrium.
        """
        made: Any = 1.0
        for name, n in self.gases.items():
            made = made * power(at.c[name], n)
        return made / self.equilibrium_constant(at.T)

    def with_traces(self, at: Local) -> Local:
        """Return a state with a trace of each gas that is used up, where rates times
        1 - Q/K have their values also without any of it.
        """
        used = [name for name, n in self.gases.items() if n < 0]
        c = {name: at.c[name] + TRACE * at.all_gases for name in used}
        x = {name: at.x[name] + TRACE for name in used}
        return replace(at, c={**at.c, **c}, x={**at.x, **x})

    def constant(self, unit: str, order: float = 0.0) -> Callable[[Any], Any]:
        """Return k = A T^b exp(-E/(R T)) as a function of T [K], where k times
        concentrations [mol/m3] of this order gives `unit`.

        Raises
        ------
        SceneError : A has another unit
        """
        table, A = self.table, self._factor(unit, order)

        def k(T: Any) -> Any:
            found: Any = A * np.exp(-table.E / R_GAS / T) if table.E else A
            return found * T**table.b if table.b else found

        return k

    def _factor(self, unit: str, order: float) -> float:
        given = self.table.A
        if not isinstance(given, str):
            return given or 0.0
        from contbed.scene.units import exponents, to_si, unit_with

        wanted = unit_with(exponents(f"({unit})*(m**3/mol)**({order})"))
        A, said = None, ""
        # published with the unit of T^b, or without it
        for each in (f"{wanted}/K**({self.table.b})", wanted):
            try:
                A = to_si(given, each)
                break
            except ValueError as error:
                said = str(error)
        if A is None:
            raise SceneError(
                f"reactions.{self.name}.A: {said}; it multiplies concentrations to "
                f"the order {order:g}: for others, such as partial pressures, give a "
                "formula, rate = ..."
            )
        if A < 0.0:
            raise SceneError(f"reactions.{self.name}.A: '{given}' is below 0")
        return A

    @cached_property
    def first_gas(self) -> tuple[str, float]:
        """The first gas on the left, which a rate of first order refers to, and its
        coefficient.

        Raises
        ------
        SceneError : there is none
        """
        for name, n in self.gases.items():
            if n < 0:
                return name, -n
        raise SceneError(
            f"reactions.{self.name}: '{self.table.equation}' takes up no gas, in which "
            "this law is of first order; give a formula, rate = ..."
        )

    @cached_property
    def solid(self) -> str:
        """The solid that reacts."""
        return next(
            name
            for name, n in self.equation.stoichiometry.items()
            if n < 0 and name in self.species.solids
        )

    def fresh(self, at: Local) -> Any:
        """Return the moles of the reacting solid, with what has reacted of it
        already [mol/m3 bed].
        """
        moles = self.equation.stoichiometry
        made = {
            name: n
            for name, n in moles.items()
            if n > 0 and name in self.species.solids
        }
        count, all_made = -moles[self.solid], sum(made.values())
        total = at.n[self.solid]
        # several products count by their share of the moles that are made
        for name, n in made.items():
            total = total + at.n[name] * (count / n) * (n / all_made)
        return total


def powers(at: Local, orders: Mapping[str, float], basis: str) -> Any:
    """Return the product of concentrations to their orders, of which at most one may be
    negative; those of solids are per volume of bed in a rate that is, else per volume of
    the particles.
    """
    factors = []
    volume = 1.0 if basis == "bed" else at.solids
    for name, n in orders.items():
        gas = name in at.c
        amount = at.c[name] if gas else at.n[name] / volume
        if n != 1.0:
            small: Any = TINY
            if at.small.amounts and 0.0 <= n < 1.0:
                whole = at.all_gases if gas else at.all_solids / volume
                small = at.small.amounts * whole
            amount = odd_power(amount, n, small)
        factors.append(amount)
    return product(factors)


@dataclass(frozen=True)
class RateLaw:
    """A rate law that scenes name.

    rate : gives the rate per `basis` of the state, all rates where it has several
        equations
    equations : of the law; none where the scene gives the equation
    needs : keys of the table without which it cannot be
    takes : keys of the table that it reads beside these; all read solid and factor, and
        all but surface mechanisms the equation
    basis : per what its rate is; None: as the scene says, else per volume of particles
        if a solid reacts, of gas if none does. Amounts `at.n` and `Case.fresh` are per
        volume of bed: divide them by `at.solids`, see `laws/grain.py`
    gases : that its rate depends on beside those of its equation
    frequency : rate over the amount of the scarcest gas [1/s]; None: by the rate
    own_film : whether it contains the film around particles
    of_solids : whether it needs solids that react
    published : constants with range and source
    """

    rate: Callable[[Case], Any]
    equations: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()
    basis: str | None = None
    gases: tuple[str, ...] = ()
    frequency: Rate | None = None
    own_film: bool = False
    of_solids: bool = False
    published: PowerLaw | None = None

    def basis_of(self, case: Case) -> str:
        """Return per what its rate is in a case."""
        return self.basis or case.basis
