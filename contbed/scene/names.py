"""Names that are not known, and which of the known ones was probably meant."""

from __future__ import annotations

import json
from difflib import get_close_matches
from typing import Any


def nearest(name: str, known: list[Any]) -> str:
    """What is allowed in place of a name that is not known, and which of it was probably meant."""
    allowed = f"allowed: {', '.join(str(item) if isinstance(item, str) else json.dumps(item) for item in known)}"
    found = near_names(name, known)
    return f"{allowed}; did you mean '{found[0]}'?" if found else allowed


def near_names(name: str, known: list[Any]) -> list[str]:
    return get_close_matches(name.lower(), [item for item in known if isinstance(item, str)], n=1, cutoff=0.6)
