"""Cross-checks of a scene: mistakes that remain although every single value is valid.

A check is a generator over the tables that its parameters name, and yields (key path,
what is wrong). It is left out when the schema has rejected one of these tables, or when
one is absent that its parameter does not allow to be None. `see` says where the other
one of two contradicting keys stands; `origin` knows the file and its folder. Warnings
are such generators too: they yield what is possible but seldom meant.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from contbed.scene.toml_lines import KeyPath, Origin, parse_key

Mistakes = Iterator[tuple[KeyPath, str]]
See = Callable[[str], str]
Check = Callable[..., Mistakes]


def mistakes(
    parts: Mapping[str, Any], broken: set[str], origin: Origin, checks: Iterable[Check]
) -> list[tuple[KeyPath, str]]:
    """Return all mistakes that the checks find.

    `parts` has the valid tables, None for an absent one; `broken` names the tables that
    the schema rejected.
    """
    available = {
        **parts,
        "origin": origin,
        "see": lambda key: f"{key} ({origin.at(parse_key(key))})",
    }
    found: list[tuple[KeyPath, str]] = []
    for check in checks:
        needs = inspect.signature(check).parameters
        if needs.keys() & broken:
            continue
        given = {name: available[name] for name in needs}
        if all(
            value is not None or "None" in str(needs[name].annotation)
            for name, value in given.items()
        ):
            found += check(**given)
    # one found at several times of the series is one
    return list(dict.fromkeys(found))
