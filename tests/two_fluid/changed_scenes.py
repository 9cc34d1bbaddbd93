"""Scenes as dictionaries, changed by the paths of their keys."""

from copy import deepcopy


def changed(scene, changes=None, without=()):
    """A copy of a scene with the values of `changes`, "table.key": value, and
    without the keys of `without`.
    """
    values = deepcopy(scene)
    for path, value in (changes or {}).items():
        *way, last = path.split(".")
        table = values
        for name in way:
            table = table.setdefault(name, {})
        table[last] = value
    for path in without:
        *way, last = path.split(".")
        table = values
        for name in way:
            table = table[name]
        del table[last]
    return values
