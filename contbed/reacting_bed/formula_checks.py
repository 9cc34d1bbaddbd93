"""Checks of the formulas of rates, and of the conversion that a rate may depend on."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from contbed.chemistry.laws import find_law, name_of
from contbed.chemistry.rate_formula import QUOTIENT
from contbed.chemistry.rate_law import SI_OF_BASIS
from contbed.chemistry.species import condensed_names
from contbed.closures.formula import parse_formula, require_names
from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.phase_checks import (
    Boundaries,
    Reactions,
    Solids,
    stoichiometry,
)
from contbed.reacting_bed.substances import (
    constituents_of,
    fed_to,
    gases_named,
    mechanism_of,
)
from contbed.scene.checking import Mistakes
from contbed.scene.toml_lines import KeyPath, Origin
from contbed.scene.units import (
    base_value,
    counts_per_time,
    factor_and_offset,
    is_unit,
    number_and_unit,
)


def conversions_are_known(
    reactions: Reactions,
    gas: s.Mixture,
    boundary: Boundaries,
    solids: Solids,
    origin: Origin,
) -> Mistakes:
    """Check that what takes the conversion of a solid has a solid that reacts to
    another: the conversion is counted by what has become of it in the bed.
    """
    takers = {}
    for name, table in reactions.items():
        law = find_law(name, table)
        given = "X" in table.parameters
        of_formula = (
            table.rate is not None and not given and "X" in _names_in(table.rate)
        )
        if of_formula or (law is not None and law.of_solids):
            takers[name] = (table, of_formula)
    species = (
        species_named(gas, boundary, solids, reactions, origin) if takers else None
    )
    if species is None:
        return
    for name, (table, of_formula) in takers.items():
        moles = stoichiometry(name, table)
        if species.unknown.intersection(moles):
            continue
        of_solids = [n for each, n in moles.items() if each in species.constituents]
        if any(n < 0 for n in of_solids) and not any(n > 0 for n in of_solids):
            used = next(each for each in moles if each in species.constituents)
            what = (
                "the conversion X" if of_formula else f"the law {name_of(name, table)}"
            )
            yield (
                ("reactions", name, "rate" if of_formula else "law"),
                f"{what} counts the solid that is made, and {used} becomes a gas "
                f"alone: write a formula with n_{used}, its moles per volume of the "
                f"bed, in which 1 - X is n_{used}/n0",
            )
        elif not any(n < 0 for n in of_solids):
            what = (
                "X is the conversion of a solid, and none reacts here; write c_, p_ or "
                "x_ with the name of a gas"
                if of_formula
                else f"the law {name_of(name, table)} is that of a solid that reacts, "
                "and none stands on the left side of the equation"
            )
            yield ("reactions", name, "rate" if of_formula else "law"), what


def _names_in(formula: str) -> Iterable[str]:
    """Return the names in a formula; none where it cannot be read."""
    try:
        return parse_formula(formula).names
    except SceneError:
        return ()


def formulas_can_be_read(
    reactions: Reactions,
    gas: s.Mixture,
    boundary: Boundaries,
    solids: Solids,
    origin: Origin,
) -> Mistakes:
    """Check formulas of rates: names, units of parameters and of the rate."""
    formulas = {
        name: table for name, table in reactions.items() if table.rate is not None
    }
    species = (
        species_named(gas, boundary, solids, reactions, origin) if formulas else None
    )
    if species is None:
        return
    gases, constituents, _ = species
    for name, table in formulas.items():
        path: KeyPath = ("reactions", name, "rate")
        for key, value in table.parameters.items():
            if isinstance(value, str):
                try:
                    base_value(value)
                except ValueError as error:
                    yield ("reactions", name, "parameters", key), str(error)
                    return
        known = {"T", "p", "R", "eps", "X", *table.parameters}
        known |= {f"{of}_{name}" for name in gases for of in "cxp"} | {
            f"n_{name}" for name in constituents
        }
        if "<->" in (table.equation or "") and gases.issuperset(
            stoichiometry(name, table)
        ):
            known.add(QUOTIENT)
        try:
            require_names(parse_formula(str(table.rate)), sorted(known))
        except SceneError as error:
            yield path, str(error)
            continue
        basis = table.basis or (
            "particle" if constituents & set(stoichiometry(name, table)) else "gas"
        )
        wanted = SI_OF_BASIS[basis]
        if table.unit is None or table.unit == wanted:
            continue
        found = factor_and_offset(table.unit, wanted)
        if found is None:
            what = (
                f"no unit of a rate per {basis}" if is_unit(table.unit) else "unknown"
            )
            text = f"is {what}; give one such as {wanted}"
            yield ("reactions", name, "unit"), text
        elif found[0] != 1.0:
            for key in _rate_constants(table.parameters):
                yield (
                    ("reactions", name, "unit"),
                    f"parameters.{key} has a unit and is taken in SI, so that the "
                    f"formula gives {wanted}: remove unit, or give the parameter as a "
                    "plain number",
                )


def _rate_constants(parameters: Mapping[str, float | str]) -> Iterator[str]:
    """Yield the parameters with a unit that counts per time."""
    for key, value in parameters.items():
        if isinstance(value, str) and counts_per_time(number_and_unit(value)[1]):
            yield key


class Names(NamedTuple):
    """Names that may be gases, those that may be constituents, and those of the gases
    that are known from equations alone.
    """

    gases: set[str]
    constituents: set[str]
    unknown: set[str]


def species_named(
    gas: s.Mixture,
    boundary: Boundaries,
    solids: Solids,
    reactions: Reactions,
    origin: Origin,
) -> Names | None:
    """Return the names of a scene; None where a composition cannot be read."""
    try:
        mechanism = mechanism_of(gas, origin.base)
        gases = {*gases_named(gas, boundary, origin.base), *gas.species}
        constituents = set(constituents_of(solids))
        for solid in solids.values():
            constituents |= set(fed_to(solid))
    except SceneError:
        return None  # other checks say so
    named: set[str] = set()
    for name, table in reactions.items():
        named |= set(stoichiometry(name, table)) - constituents
    unknown = named - gases - (set() if mechanism is None else set(mechanism.names))
    if constituents and unknown:
        constituents |= unknown.intersection(condensed_names())
    return Names(gases | (named - constituents), constituents, unknown - constituents)
