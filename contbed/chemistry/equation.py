"""Chemical equations: what they read, what they make, whether their atoms balance."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from contbed.errors import SceneError

BALANCED = 1e-6  # atoms per mole of reaction within which an equation balances


def stoichiometry(reaction: str) -> dict[str, float]:
    """Moles made of each species by "CO + 0.5 O2 -> CO2"."""
    left, right = map(_moles, reaction.replace("<->", "->").split("->"))
    names = dict.fromkeys([*left, *right])
    return {name: right.get(name, 0.0) - left.get(name, 0.0) for name in names}


def _moles(side: str) -> dict[str, float]:
    """Return the moles of each species on a side, "CO + 0.5 O2"."""
    out: dict[str, float] = {}
    for term in side.split(" + "):
        count, _, name = term.strip().rpartition(" ")
        out[name] = out.get(name, 0.0) + (float(count) if count else 1.0)
    return out


@dataclass(frozen=True)
class Equation:
    """Moles of each species made per mole of a reaction, whether it is reversible, and
    the moles on the left as they are written.
    """

    stoichiometry: Mapping[str, float]
    reversible: bool
    left: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, text: str) -> Equation:
        """Read "CH4 + 12 Fe2O3 -> 8 Fe3O4 + CO2 + 2 H2O"; SceneError says what is
        wrong.
        """
        if text.replace("<->", "->").count("->") != 1:
            raise SceneError(
                'needs one arrow: "CO + H2O <-> CO2 + H2", or -> where it does not run '
                "back"
            )
        try:
            found = stoichiometry(text)
        except ValueError as error:
            raise SceneError(
                f"cannot be read ({error}); write numbers before names, with spaces"
            ) from None
        if any(not name or " " in name for name in found):
            raise SceneError(
                'cannot be read; write it like "CH4 + 2 O2 -> CO2 + 2 H2O", with '
                "spaces around +"
            )
        return cls(
            {name: count for name, count in found.items() if count},
            "<->" in text,
            _moles(text.replace("<->", "->").partition("->")[0]),
        )


def unbalanced(
    made: Mapping[str, float], atoms: Callable[[str], Mapping[str, float]]
) -> list[str]:
    """Return what is wrong with the atoms of an equation, one sentence an element.

    Parameters
    ----------
    made : moles of each species per mole of reaction, negative for what is consumed
    atoms : gives the atoms of a species by its name, see `species.atoms_of`
    """
    total: dict[str, float] = {}
    try:
        for name, count in made.items():
            for element, number in atoms(name).items():
                total[element] = total.get(element, 0.0) + count * number
    except SceneError as error:
        return [str(error)]
    return [
        f"{'makes' if found > 0 else 'loses'} {abs(found):.6g} atoms of {element} per "
        "mole of reaction; correct its coefficients"
        for element, found in total.items()
        if abs(found) > BALANCED
    ]
