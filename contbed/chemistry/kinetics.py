"""Rates of the reactions of a scene at a point of the bed, in moles of reaction per
volume of bed and time.

`local.Local` is the state that they see, `chemistry.laws` holds their rate laws. K of a
reversible reaction comes from the thermodynamics of its species.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.chemistry.effectiveness import effectiveness_of
from contbed.chemistry.equation import Equation
from contbed.chemistry.laws import equations_of, law_of
from contbed.chemistry.local import Local, Rate
from contbed.chemistry.power_law import PowerLaw
from contbed.chemistry.rate_formula import formula_of
from contbed.chemistry.rate_law import Case, RateLaw
from contbed.chemistry.species import Species
from contbed.closures.formula import parse_formula
from contbed.scene.reactions import Reaction as ReactionTable


@dataclass(frozen=True)
class Reaction:
    """One reaction. `site` is "gas" or "particle"; `own_film` says that the law
    contains the film around particles.

    `step` is None where `rate` gives the rate; else `rate` gives those of all steps of
    a law at once, as they share their work, and this is the step that is meant.
    """

    name: str
    equation: Equation
    rate: Rate
    site: str
    own_film: bool = False
    step: int | None = None
    phase: str | None = None  # solid phase in which it runs
    alone: str | None = None  # name without the phase, where it runs in several
    gases: frozenset[str] = frozenset()  # of its equation and of its rate
    has_roots: bool = False  # whether orders or a formula have powers between 0 and 1
    frequency: Rate | None = None  # rate over the amount of the scarcest gas [1/s]
    published: PowerLaw | None = None  # constants of its law, with range and source

    @property
    def key(self) -> str:
        """Name without the solid phase: the key in [reactions] of a reaction without
        stages.
        """
        return self.alone or self.name

    @property
    def stoichiometry(self) -> Mapping[str, float]:
        """Moles made of each species per mole of reaction."""
        return self.equation.stoichiometry


def reactions_of(
    name: str, table: ReactionTable, species: Species, with_effectiveness: bool = False
) -> list[Reaction]:
    """Return the reactions of a table in one place, one for each stage of its law.

    `with_effectiveness` says that particles with a diffusivity have one by their Thiele
    modulus.

    Raises
    ------
    SceneError : it has no equation or no law
    """
    law = law_of(name, table)
    cases = [
        Case(key, table, equation, species)
        for key, equation in equations_of(name, table).items()
    ]
    if len(cases) == 1 and table.surface is None:
        return [_one(cases[0], law, with_effectiveness)]
    basis = law.basis_of(cases[0])
    rates = _per_bed(law.rate(cases[0]), basis, table.factor)
    return [
        Reaction(
            case.name,
            case.equation,
            rates,
            "gas" if basis == "gas" else "particle",
            law.own_film,
            step,
            gases=frozenset(species.gases) & case.equation.stoichiometry.keys(),
        )
        for step, case in enumerate(cases)
    ]


def rates_of(
    reactions: Sequence[Reaction], local: Callable[[Reaction], Local]
) -> list[Any]:
    """Return the rates of reactions at the state that `local` gives each; all steps of
    a law are found together.
    """
    found: list[Any] = []
    together: dict[Rate, Any] = {}
    for reaction in reactions:
        if reaction.step is None:
            found.append(reaction.rate(local(reaction)))
            continue
        if reaction.rate not in together:
            together[reaction.rate] = reaction.rate(local(reaction))
        found.append(together[reaction.rate][reaction.step])
    return found


def basis_of(
    name: str, table: ReactionTable, equation: Equation, species: Species
) -> str:
    """Return where a reaction runs, as the basis of its rate."""
    return law_of(name, table).basis_of(Case(name, table, equation, species))


def _one(case: Case, law: RateLaw, with_effectiveness: bool) -> Reaction:
    table, basis = case.table, law.basis_of(case)
    used = {*case.equation.stoichiometry, *case.orders}
    of_gases = basis == "bed" and not used & set(case.species.solids)
    site = "gas" if basis == "gas" or of_gases else "particle"
    rate = law.rate(case)
    slowed = with_effectiveness and table.diffusivity and site == "particle"
    if slowed and not law.own_film:
        rate = _slowed(rate, case, basis)
    roots = any(0.0 <= n < 1.0 for n in case.orders.values())
    if table.rate is not None:
        formula, parameters, _ = formula_of(table, basis)
        roots = formula.has_roots(parameters)
    return Reaction(
        case.name,
        case.equation,
        _per_bed(rate, basis, table.factor),
        site,
        law.own_film,
        gases=frozenset(case.species.gases) & (used | gases_of_rate(table, law)),
        has_roots=roots,
        frequency=law.frequency and _per_bed(law.frequency, basis, table.factor),
        published=law.published,
    )


def gases_of_rate(table: ReactionTable, law: RateLaw) -> set[str]:
    """Return the species that a rate names beside its equation and orders."""
    found = set(law.gases)
    if table.rate is not None:
        found |= {
            name.partition("_")[2]
            for name in parse_formula(table.rate).names
            if name[:2] in ("c_", "p_", "x_")
        }
    return found


def _per_bed(rate: Rate, basis: str, factor: float) -> Rate:
    """Return a rate per volume of bed from one per basis; a list of rates where a law
    has several.
    """

    def scaled(at: Local) -> Any:
        volume = {
            "gas": at.eps,
            "particle": at.solids,
            "bed": 1.0,
            "catalyst": at.catalyst,
        }[basis]
        scale = factor * volume
        found = rate(at)
        if isinstance(found, list):
            return [each * scale for each in found]
        return found * scale

    return scaled


def _slowed(rate: Rate, case: Case, basis: str) -> Rate:
    """Return a rate times the effectiveness of a sphere.

    The modulus is that of the size of the rate per concentration of the first gas that
    is used up: on the left, or on the right where the reaction runs back.
    """
    gas, moles = case.first_gas
    made = [(name, n) for name, n in case.gases.items() if n > 0]
    back, back_moles = made[0] if made else (gas, moles)

    def slowed(at: Local) -> Any:
        value = rate(at)
        share = {
            "particle": 1.0,
            "bed": 1.0 / at.solids,
            "catalyst": at.catalyst / at.solids,
        }[basis]
        least = 1e-9 * at.all_gases
        ahead: Any = np.asarray(getattr(value, "value", value)) >= 0.0
        used: Any = np.where(ahead, at.c[gas] / moles, at.c[back] / back_moles)
        k: Any = np.abs(value) * share / np.maximum(used, least)
        return value * effectiveness_of(at.radius, k, case.table.diffusivity)

    return slowed
