"""Keys of a scene that only other models have.

A file may describe one reactor for several models. With the key `model`, what this
model does not know but another does is ignored and listed by `contbed plan`; what
no model knows stays a mistake. Without that key every table must be known.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from contbed.scene import schema
from contbed.scene.toml_lines import KeyPath


def take_keys_of_others(
    values: dict[str, Any], own: schema.Node, others: Sequence[schema.Node]
) -> list[KeyPath]:
    """Remove the keys that only other models have from the values of a scene.

    Parameters
    ----------
    values : tables of the scene; keys are removed from it
    own : JSON schema of the model that reads the scene
    others : JSON schemas of all other models

    Returns
    -------
    paths of what was removed; a table stands for all that it holds
    """
    found = list(_foreign(values, own, others, ()))
    for path in found:
        table: Any = values
        for key in path[:-1]:
            table = table[key]
        del table[path[-1]]
    return found


def bottom_of_a_bubbling_bed(
    values: dict[str, Any], ignored: Sequence[KeyPath]
) -> tuple[KeyPath, ...]:
    """Remove [boundary.bottom] of a bubbling bed, of which a file speaks as well, from
    the values of a scene on a line, which has no such end; return its path.
    """
    mesh, boundary = values.get("mesh"), values.get("boundary")
    if (
        ("bubbling_bed",) not in ignored
        or not isinstance(mesh, dict)
        or mesh.get("type") != "line"
        or not isinstance(boundary, dict)
        or boundary.pop("bottom", None) is None
    ):
        return ()
    return (("boundary", "bottom"),)


def _foreign(
    values: Mapping[str, Any],
    own: schema.Node,
    others: Sequence[schema.Node],
    above: KeyPath,
) -> Iterator[KeyPath]:
    for key, value in values.items():
        path = (*above, key)
        if schema.at(own, path):
            for items, place in _tables(value, path):
                yield from _foreign(items, own, others, place)
        elif any(schema.at(other, path) for other in others):
            yield path


def _tables(value: Any, path: KeyPath) -> Iterator[tuple[Mapping[str, Any], KeyPath]]:
    """Yield a table, or the tables of a list, with their paths."""
    if isinstance(value, Mapping):
        yield value, path
    elif isinstance(value, list):
        for index, item in enumerate(value):
            if isinstance(item, Mapping):
                yield item, (*path, index)
