"""Rate laws by name, from the dictionaries `LAWS` of the modules of this folder.

Laws of one reaction are called REACTION.NAME, such as "CO_oxidation.howard"; scenes then
write `law = "howard"` in [reactions.CO_oxidation], and the first is the default.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from contbed.chemistry.char_and_lime import OF_BOILERS
from contbed.chemistry.equation import Equation
from contbed.chemistry.rate_formula import FORMULA
from contbed.chemistry.rate_law import RateLaw
from contbed.chemistry.surface import SURFACE, surface_of
from contbed.errors import SceneError
from contbed.scene.names import nearest
from contbed.scene.reactions import Reaction


@cache
def every() -> dict[str, RateLaw]:
    """Return all rate laws by name."""
    found: dict[str, RateLaw] = {}
    for module in iter_modules(__path__):
        found |= import_module(f"{__name__}.{module.name}").LAWS
    return found


def laws_of(reaction: str) -> list[str]:
    """Return the names of the laws that are those of one reaction, the default
    first.
    """
    return [
        name.removeprefix(f"{reaction}.")
        for name in every()
        if name.startswith(f"{reaction}.")
    ]


def known_laws(reaction: str) -> list[str]:
    """Return the laws that a reaction of this name may have."""
    own = [name for name, law in every().items() if law.needs]
    named = [name for name in every() if "." not in name and name not in own]
    return sorted(own, key="power".__ne__) + named + laws_of(reaction)


def name_of(reaction: str, table: Reaction) -> str:
    """Return the law of a reaction: the stated one, the default of its name, or a
    power law.
    """
    if table.law is not None:
        return table.law
    own = laws_of(reaction)
    return own[0] if own and table.equation is None else "power"


def find_law(reaction: str, table: Reaction) -> RateLaw | None:
    """Return the rate law of a reaction; None if there is none of its name."""
    if table.surface is not None:
        return SURFACE
    if table.rate is not None:
        return FORMULA
    name, found = name_of(reaction, table), every()
    return found.get(f"{reaction}.{name}") or found.get(name)


def law_of(reaction: str, table: Reaction) -> RateLaw:
    """Return the rate law of a reaction.

    Raises
    ------
    SceneError : there is none of its name
    """
    law = find_law(reaction, table)
    if law is None:
        known = nearest(str(table.law), known_laws(reaction))
        what = "unknown rate law"
        if table.law in OF_BOILERS:
            what = "a rate law of bubbling beds, which packed beds do not have"
        raise SceneError(f"{what}; {known}")
    return law


def is_catalytic(reaction: str, table: Reaction) -> bool:
    """Return whether the law of a reaction gives its rate per mass of catalyst."""
    law = find_law(reaction, table)
    return law is not None and law.basis == "catalyst"


def equations_of(reaction: str, table: Reaction) -> dict[str, Equation]:
    """Return the equations that a table of a reaction stands for, by name; a law
    with stages has several, a surface mechanism one for each gas that it makes.

    Raises
    ------
    SceneError : it has none, or one that cannot be read
    """
    if table.surface is not None:
        found_by_gas = surface_of(table).equations
        return {f"{reaction}_{gas}": item for gas, item in found_by_gas.items()}
    if table.equation is not None:
        return {reaction: Equation.of(table.equation)}
    found = law_of(reaction, table).equations
    if not found:
        raise SceneError("the equation is missing")
    if len(found) == 1:
        return {reaction: Equation.of(found[0])}
    return {f"{reaction}_{k + 1}": Equation.of(text) for k, text in enumerate(found)}


def species_in(reaction: str, table: Reaction) -> set[str]:
    """Return the species of the equations of a reaction.

    Raises
    ------
    SceneError : it has none, or one that cannot be read
    """
    equations = equations_of(reaction, table).values()
    return {name for equation in equations for name in equation.stoichiometry}


def species_named(reaction: str, table: Reaction) -> set[str]:
    """Return the species of a reaction, those of its orders and its law included.

    Raises
    ------
    SceneError : it has no equation or law, or one that cannot be read
    """
    equations = equations_of(reaction, table).values()
    left = {name for equation in equations for name in equation.left}
    of_rate = {*(table.orders or left), *law_of(reaction, table).gases}
    return species_in(reaction, table) | of_rate
