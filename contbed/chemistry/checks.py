"""Checks of tables of reactions that every model makes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from contbed.chemistry.equation import unbalanced
from contbed.chemistry.laws import equations_of, law_of, name_of
from contbed.errors import SceneError
from contbed.scene.checking import Mistakes
from contbed.scene.reactions import Reaction

# keys of a table with a surface mechanism, those that it needs first
OF_SURFACES = ("surface", "mechanism", "area")
BESIDE_SURFACES = {"basis", "solid", "factor"}
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
    if table.rate is not None and (table.law is not None or table.A is not None):
        yield (
            (*path, "rate"),
            "a formula is the whole rate; remove law, A, E and orders, or rate",
        )
    try:
        law = law_of(name, table)
    except SceneError as error:
        yield (*path, "law"), str(error)
        return
    of_equation = path if table.equation is None else (*path, "equation")
    try:
        equations = equations_of(name, table)
    except SceneError as error:
        yield of_equation, str(error)
        equations = {}
    for equation in equations.values():
        for text in unbalanced(equation.stoichiometry, atoms):
            yield of_equation, text
    if table.rate is not None:
        return
    law_name = name_of(name, table)
    for key in law.needs:
        if getattr(table, key) is None:
            what = ENERGY if key == "E" else key
            yield (*path, key), f"missing; the law {law_name} needs {what}"
    if table.basis is not None and law_name != "power":
        yield (
            (*path, "basis"),
            f"has no meaning with the law {law_name}, whose rate has its own",
        )


def _surface_is_whole(
    name: str, table: Reaction, atoms: Callable[[str], Mapping[str, float]]
) -> Mistakes:
    """Check that a surface mechanism can be read and its gases have the atoms that it
    states.
    """
    path = ("reactions", name)
    missing = [key for key in OF_SURFACES if getattr(table, key) is None]
    for key in missing:
        text = f"missing; a surface mechanism needs {', '.join(OF_SURFACES)}"
        yield (*path, key), text
    for key in sorted(table.model_fields_set - {*OF_SURFACES, *BESIDE_SURFACES}):
        yield (*path, key), "has no meaning with a surface mechanism; remove it"
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
