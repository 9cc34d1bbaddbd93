"""Tables as TOML text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def toml_text(content: Mapping[str, Any]) -> str:
    """Return tables as TOML: scalars, then one table after the other, inner tables in
    one line.

    >>> print(toml_text({"title": "bed", "mesh": {"type": "line", "length": 0.5}}), end="")
    title = "bed"
    <BLANKLINE>
    [mesh]
    type = "line"
    length = 0.5
    """
    scalars = {key: value for key, value in content.items() if not _is_table(value)}
    lines = [f"{_key(key)} = {_value(value)}" for key, value in scalars.items()]
    for key, value in content.items():
        if isinstance(value, Mapping):
            lines += [
                "",
                f"[{_key(key)}]",
                *(f"{_key(name)} = {_value(item)}" for name, item in value.items()),
            ]
        elif _is_table(value):
            for table in value:
                lines += [
                    "",
                    f"[[{_key(key)}]]",
                    *(f"{_key(name)} = {_value(item)}" for name, item in table.items()),
                ]
    return "\n".join(lines).lstrip("\n") + "\n"


def _is_table(value: Any) -> bool:
    """Return whether a value is a table, or a list of tables."""
    if isinstance(value, list | tuple):
        return bool(value) and all(isinstance(item, Mapping) for item in value)
    return isinstance(value, Mapping)


def _key(name: str) -> str:
    return (
        name
        if name.replace("_", "").replace("-", "").isalnum() and name.isascii()
        else json.dumps(name)
    )


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return (
            "{"
            + ", ".join(
                f"{_key(name)} = {_value(item)}" for name, item in value.items()
            )
            + "}"
        )
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    return (
        json.dumps(value, ensure_ascii=False)
        if isinstance(value, str | bool | int)
        else repr(float(value))
    )
