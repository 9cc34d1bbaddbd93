"""Scenes of bubbling beds for the tests."""

import tomllib
from copy import deepcopy
from pathlib import Path

from contbed.loading import from_dict

STUDY = Path(__file__).parents[2] / "studies" / "bubbling_bed_case1"
QUIET = {"plots": False, "fields": False}


def values(name="p1"):
    """The tables of a scene of case1."""
    return tomllib.loads((STUDY / f"{name}.toml").read_text(encoding="utf-8")) | {"output": dict(QUIET)}


def case1(name="p1", **tables):
    """A scene of case1 with tables replaced; None removes one."""
    found = values(name) | tables
    return from_dict({key: value for key, value in found.items() if value is not None})


def species(**changes):
    """The species of case1 with keys replaced; None removes a key."""
    found = deepcopy(values()["species"])
    for name, keys in changes.items():
        found[name] = {key: value for key, value in {**found[name], **keys}.items() if value is not None}
    return found


def one(**changes):
    """A bed of inert particles between mirrors, without bubbles, radiation and surfaces."""
    inert = {"volume_fraction": 1.0, "diameter": 1e-3, "gas_coefficient": 100.0, "conductivity": 5.0}
    tables = {
        "bubbling_bed": {"height": 0.6, "section": 1.3, "solids_fraction": 0.5},
        "gas": {"capacity_flow": 300.0, "temperature": 300.0},
        "species": {"inert": inert | changes.pop("inert", {})},
        "output": dict(QUIET),
    }
    return from_dict(tables | changes)
