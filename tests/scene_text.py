"""Scenes of tests in the words of a file: whole tables, and keys that change."""

import textwrap
import tomllib
from copy import deepcopy


def put(scene, key, value):
    """Set the value of a dotted key in place, None removes it; tables that the scene
    lacks are added.
    """
    *above, last = key.split(".")
    for name in above:
        scene = scene.setdefault(name, {})
    if value is None:
        scene.pop(last, None)
    else:
        scene[last] = value


def set_keys(scene, text):
    """Replace the value of each key that the text names, one `table.key = value` a line;
    tables that the scene lacks are added.
    """
    for line in filter(str.strip, text.splitlines()):
        key, _, value = line.strip().partition(" = ")
        put(scene, key, tomllib.loads(f"value = {value}")["value"])


def scene_of(text, values=None):
    """Return the tables of a text as nested dicts, with the values of dotted keys."""
    return changed(tomllib.loads(textwrap.dedent(text)), values)


def changed(scene, changes=None, without=()):
    """Return a copy of a scene with the values of dotted keys and without others."""
    scene = deepcopy(scene)
    for key, value in (changes or {}).items():
        put(scene, key, value)
    for key in without:
        put(scene, key, None)
    return scene
