"""Mole fractions from the text of a composition."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from contbed.errors import SceneError

SUM = 1e-3  # by which fractions may miss one, as they are rounded


def mole_fractions(composition: str | Mapping[str, float]) -> dict[str, float]:
    """Return mole fractions above zero that sum to one.

    Parameters
    ----------
    composition : "N2:0.79, O2:0.21" or {"N2": 0.79, "O2": 0.21}, in any common
        scale [mol]; one bare name is a pure gas

    Returns
    -------
    species -> mole fraction [-]
    """
    pairs = (
        list(composition.items())
        if isinstance(composition, Mapping)
        else _pairs(composition)
    )
    amounts: dict[str, float] = {}
    for species, given in pairs:
        try:
            amount = float(given)
        except (TypeError, ValueError):
            amount = math.nan
        if not (amount >= 0.0 and math.isfinite(amount)):
            raise SceneError(
                f"composition: the amount of {species} is {given!r}; it must be a "
                "number, 0 or more"
            )
        if species in amounts:
            raise SceneError(f"composition: {species} is given twice")
        amounts[species] = amount
    total = sum(amounts.values())
    if total <= 0.0:
        raise SceneError(
            f"composition {composition!r} is empty; give at least one species, such as "
            "'N2:0.79, O2:0.21'"
        )
    return {
        species: amount / total for species, amount in amounts.items() if amount > 0.0
    }


def require_sum(composition: str, within: float = SUM, in_moles: bool = True) -> None:
    """Check that fractions sum to one `within` a number; amounts above 1 are `in_moles`
    and may sum to anything.

    Raises
    ------
    SceneError : they do not, or the text cannot be read, see `mole_fractions`
    """
    mole_fractions(composition)
    amounts = [float(amount) for _, amount in _pairs(composition)]
    total, fractions = sum(amounts), max(amounts) <= 1.0 or not in_moles
    if fractions and abs(total - 1.0) > within:
        raise SceneError(
            f"fractions sum to {total:.6g}, not to 1; correct them, or write amounts "
            "in mol above 1"
        )


def names_in(composition: str) -> tuple[str, ...]:
    """Return all species that the text of a composition names, those of amount 0
    included.
    """
    return tuple(name for name, _ in _pairs(composition))


def _pairs(text: str) -> list[tuple[str, str]]:
    words = re.split(r"[,;\s]+", re.sub(r"\s*:\s*", ":", text).strip(" ,;\t\n"))
    if len(words) == 1 and words[0] and ":" not in words[0]:
        return [(words[0], "1")]
    pairs = []
    for word in filter(None, words):
        species, _, amount = word.rpartition(":")
        if not species or not amount:
            raise SceneError(
                f"composition {text!r}: cannot read {word!r}; write 'N2:0.79, O2:0.21' "
                "(mole fractions)"
            )
        pairs.append((species, amount))
    return pairs
