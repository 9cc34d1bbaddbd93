"""Scenes of tests in the words of a file: whole tables, and keys that change."""

import textwrap
import tomllib


def set_keys(scene, text):
    """Replace the value of each key that the text names, one `table.key = value` a line;
    tables that the scene lacks are added.
    """
    for line in text.strip().splitlines():
        key, _, value = line.strip().partition(" = ")
        *above, last = key.split(".")
        table = scene
        for name in above:
            table = table.setdefault(name, {})
        table[last] = tomllib.loads(f"value = {value}")["value"]


def scene_of(text, values=None):
    """Return the tables of a text as nested dicts, with the values of dotted keys."""
    scene = tomllib.loads(textwrap.dedent(text))
    for key, value in (values or {}).items():
        *above, last = key.split(".")
        table = scene
        for name in above:
            table = table.setdefault(name, {})
        table[last] = value
    return scene
