"""Checks of tables of reactions that every model makes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from contbed.chemistry.equation import unbalanced
from contbed.chemistry.laws import equations_of, law_of, name_of
from contbed.chemistry.rate_formula import QUOTIENT
from contbed.chemistry.rate_law import RateLaw
from contbed.chemistry.surface import SURFACE
from contbed.errors import SceneError
from contbed.scene.checking import Mistakes
from contbed.scene.reactions import Reaction

OF_SURFACES = SURFACE.needs
ENERGY = "the activation energy, 0 for a rate that does not depend on temperature"


def reaction_is_whole(
    name: str, table: Reaction, atoms: Callable[[str], Mapping[str, float]]
) -> Mistakes:
    """Check that a reaction has an equation whose elements balance, and one rate law
    with its constants or a formula.

    Parameters
    ----------
    atoms : gives the atoms of a species by its name
    """
    path = ("reactions", name)
    if any(key in table.model_fields_set for key in OF_SURFACES):
        yield from _surface_is_whole(name, table, atoms)
        return
    try:
        law = law_of(name, table)
    except SceneError as error:
        yield (*path, "law"), str(error)
        return
    law_name = name_of(name, table)
    if table.rate is None:
        yield from _keys_are_read(name, table, law, f"the law {law_name}")
    else:
        yield from _keys_are_read(
            name, table, law, "a formula, which is the whole rate"
        )
    of_equation = path if table.equation is None else (*path, "equation")
    try:
        equations = equations_of(name, table)
    except SceneError as error:
        yield of_equation, str(error)
        equations = {}
    for equation in equations.values():
        for text in unbalanced(equation.stoichiometry, atoms):
            yield of_equation, text
    returns = any(each.reversible for each in equations.values())
    by_formula = table.rate is None or QUOTIENT in table.rate
    if table.equilibrium_factor != 1.0 and equations and not (returns and by_formula):
        yield (
            (*path, "equilibrium_factor"),
            "has no meaning where the rate does not run back: write <->, and "
            f"{QUOTIENT} in a formula, or remove it",
        )
    for key in law.needs:
        if getattr(table, key) is None:
            what = ENERGY if key == "E" else key
            yield (*path, key), f"missing; the law {law_name} needs {what}"


def _keys_are_read(name: str, table: Reaction, law: RateLaw, what: str) -> Mistakes:
    """Check that a table has no key which its law does not read."""
    read = {"solid", "factor", *law.needs, *law.takes}
    if table.surface is None:
        read.add("equation")
    if table.rate is None:
        read.add("law")
    for key in sorted(table.model_fields_set - read):
        absent = Reaction.model_fields[key].get_default(call_default_factory=True)
        if getattr(table, key) != absent:
            yield ("reactions", name, key), f"has no meaning with {what}; remove it"


def _surface_is_whole(
    name: str, table: Reaction, atoms: Callable[[str], Mapping[str, float]]
) -> Mistakes:
    """Check that a surface mechanism can be read and its gases have the atoms that it
    states.
    """
    path = ("reactions", name)
    missing = [key for key in OF_SURFACES if getattr(table, key) is None]
    for key in missing:
        text = (
            f"missing; a surface mechanism needs {', '.join(OF_SURFACES)}. Reactions in "
            "the gas of a mechanism are not read: give each its table with equation, A, "
            "b and E"
        )
        yield (*path, key), text
    yield from _keys_are_read(name, table, SURFACE, "a surface mechanism")
    if table.basis not in (None, "particle", "bed"):
        yield (*path, "basis"), "area is over the volume of particles, or of the bed"
    if missing:
        return
    try:
        equations = equations_of(name, table)
    except SceneError as error:
        yield (*path, "surface"), str(error)
        return
    for equation in equations.values():
        for text in unbalanced(equation.stoichiometry, atoms):
            yield (*path, "surface"), text
