"""Scenes of bubbling beds for the tests, and runs whose energy balance closes."""

import tomllib
from copy import deepcopy
from pathlib import Path

import contbed
from contbed.loading import from_dict
from tests.balances import assert_closed
from tests.scene_text import scene_of

STUDY = Path(__file__).parents[2] / "studies" / "bubbling_bed_case1"
QUIET = {"plots": False, "fields": False}
# short names of tables within others
INLET = {"inlet": ("boundary", "bottom", "gas")}
OF_THE_BED = (
    "bubbles",
    "tubes",
    "walls",
    "distributor",
    "freeboard",
    "drain",
    "release",
)
PLACES = INLET | {name: ("bubbling_bed", name) for name in OF_THE_BED}


def put(tables, path, value):
    """Replace a value of nested tables under a path, whose first step may be a short
    name; None removes it.

    A new [bubbling_bed] keeps the tables within the former one.
    """
    *steps, last = (*PLACES.get(path[0], path[:1]), *path[1:])
    if (*steps, last) == ("bubbling_bed",):
        former = tables["bubbling_bed"]
        value = {name: former[name] for name in OF_THE_BED if name in former} | value
    table = tables
    for step in steps:
        table = table.setdefault(step, {})
    if value is None:
        table.pop(last, None)
    else:
        table[last] = value


def changed(tables, changes):
    """Tables with values replaced under paths, or under names of tables."""
    found = deepcopy(tables)
    for path, value in changes.items():
        put(found, (path,) if isinstance(path, str) else path, value)
    return found


def values(name="p1"):
    """The tables of a scene of case1."""
    return tomllib.loads((STUDY / f"{name}.toml").read_text(encoding="utf-8")) | {
        "output": dict(QUIET)
    }


def case1(name="p1", **tables):
    """A scene of case1 with tables replaced; None removes one."""
    return from_dict(changed(values(name), tables))


def solids(**changes):
    """The solid phases of case1 with keys replaced; None removes a key."""
    found = deepcopy(values()["solids"])
    for name, keys in changes.items():
        found[name] = {
            key: value
            for key, value in {**found[name], **keys}.items()
            if value is not None
        }
    return found


def one(**changes):
    """A bed of inert particles between mirrors, without bubbles, radiation and
    surfaces.
    """
    inert = {
        "volume_share": 1.0,
        "diameter": 1e-3,
        "gas_coefficient": 100.0,
        "mixing_conductivity": 5.0,
    }
    tables = scene_of(
        """
            bubbling_bed = { height = 0.6, section = 1.3, solids_fraction = 0.5 }

            [boundary]
            bottom = { gas = { capacity_flow = 300.0, temperature = 300.0 } }
        """,
        {"solids.inert": inert | changes.pop("inert", {}), "output": dict(QUIET)},
    )
    return from_dict(changed(tables, changes))


def solved(scene, closed=1e-12):
    """Result of a run whose energy balance closes."""
    result = contbed.run(scene)
    assert_closed(result, closed, "energy")
    return result
