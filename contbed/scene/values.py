"""Values of a scene by their dotted keys: read one, or replace one in a copy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any

from contbed.scene.humid_air import HumidAir
from contbed.scene.quantities import Table
from contbed.scene.toml_lines import KeyPath, parse_key

PARAMETERS = "parameters"  # table of the constants of a formula


def is_constant(path: KeyPath) -> bool:
    """Return whether a key is a constant of a formula or of a rate law, which takes a
    plain number or a text with the unit that its formula asks for.
    """
    return PARAMETERS in path[:-1] or (
        path[-3:-2] == ("reactions",) and path[-1] == "A"
    )


def value_at(scene: Any, key: str) -> Any:
    """Return the value of a dotted key; None where there is none."""
    return at(scene, parse_key(key))


def number_at(scene: Any, key: str) -> float | None:
    """Return the number of a dotted key, in SI that of a constant which is written
    with a unit, "360 1/h"; None where there is none.
    """
    path, found = parse_key(key), value_at(scene, key)
    if isinstance(found, str) and is_constant(path):
        from contbed.scene.units import base_value

        with suppress(ValueError):  # reported where formulas are checked
            return base_value(found)
    number = isinstance(found, int | float) and not isinstance(found, bool)
    return float(found) if number else None


def at(part: Any, path: KeyPath) -> Any:
    """Return what is at a path in a scene, a table or a list; None where there is
    nothing.
    """
    for step in path:
        try:
            inside = isinstance(part, dict | list | tuple)
            part = part[step] if inside else getattr(part, str(step))
        except (KeyError, IndexError, TypeError, AttributeError):
            return None
    return part


def tables(part: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Table]]:
    """Yield all tables of a scene, of one of its tables or of a list, with their paths."""
    below: Iterable[tuple[Any, Any]] = ()
    if isinstance(part, Table):
        yield path, part
        below = ((name, getattr(part, name)) for name in type(part).model_fields)
    elif isinstance(part, dict):
        below = part.items()
    elif isinstance(part, list | tuple):
        below = enumerate(part)
    for name, value in below:
        if isinstance(value, Table | dict | list | tuple):
            yield from tables(value, (*path, name))


def flat(
    table: Mapping[str, Any],
    is_value: Callable[[Any], bool] = lambda item: not isinstance(item, Mapping),
    above: tuple[str, ...] = (),
) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the values below a table by path, whether written as "a.b" = 1, a.b = 1 or
    in sub-tables.
    """
    for key, item in table.items():
        if is_value(item):
            yield (*above, key), item
        else:
            yield from flat(item, is_value, (*above, key))


def with_value(part: Any, path: tuple[Any, ...], value: Any) -> Any:
    """Return the scene, table or list with one value replaced."""
    if not path:
        return value
    if isinstance(part, dict):
        return part | {path[0]: with_value(part[path[0]], path[1:], value)}
    if isinstance(part, tuple):
        k = path[0]
        return (*part[:k], with_value(part[k], path[1:], value), *part[k + 1 :])
    changed = with_value(getattr(part, path[0]), path[1:], value)
    found = part.model_copy(update={path[0]: changed})
    return found.of_air() if isinstance(found, HumidAir) else found
