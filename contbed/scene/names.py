"""Messages for unknown names: the known names, and which of them was probably meant."""

from __future__ import annotations

import json
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any


def nearest(name: str, known: list[Any]) -> str:
    """Say which names are allowed in place of an unknown one, and which of them was
    probably meant.
    """
    allowed = (
        "allowed: "
        f"{', '.join(str(item) if isinstance(item, str) else json.dumps(item) for item in known)}"
    )
    found = near_names(name, known)
    return f"{allowed}; did you mean '{found[0]}'?" if found else allowed


def near_names(name: str, known: list[Any]) -> list[str]:
    """Return the known name that is most similar to `name`, as a list of one; empty
    if none is similar.
    """
    return get_close_matches(
        name.lower(), [item for item in known if isinstance(item, str)], n=1, cutoff=0.6
    )


def nearest_of(name: str, known: list[str]) -> str:
    """Name the most similar ones only, as there are many."""
    found = get_close_matches(name, known, n=3, cutoff=0.4)
    return (
        f"nearest: {', '.join(found)}"
        if found
        else "`contbed list` shows results, a run's summary.json those it has"
    )


def several(names: str | Iterable[str]) -> tuple[str, ...]:
    """Return names without repetition; a text is one name, not a list of letters."""
    return tuple(dict.fromkeys([names] if isinstance(names, str) else names))


def first_paragraph(text: object) -> str:
    """Return the first paragraph of a docstring in one line; empty for None."""
    return " ".join(str(text or "").partition("\n\n")[0].split())
