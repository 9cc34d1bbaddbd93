"""Scenes of bubbling beds whose coefficients follow from closures."""

from copy import deepcopy

from contbed.loading import from_dict

HOT = {
    "bubbling_bed": {"height": 0.6, "section": 1.0, "solids_fraction": 0.5},
    "bubbles": {},
    "gas": {
        "mass_flow": 0.6, "composition": "N2:0.79, O2:0.21", "temperature": 300.0,
        "release": {"rate": 1.2e6, "length": 0.3},
    },
    "species": {
        "inert": {
            "volume_fraction": 0.98, "diameter": 7e-4, "density": 2600.0, "heat_capacity": 1000.0, "emissivity": 0.6,
            "gas_coefficient": "gunn", "conductivity": 2e4,
        },
        "char": {
            "volume_fraction": 0.02, "diameter": 3e-3, "density": 1200.0, "heat_capacity": [1000.0, 0.5],
            "emissivity": 0.8, "gas_coefficient": "ranz_marshall", "conductivity": "kunii_levenspiel",
            "exchange": {"inert": "agu"},
            "feed": {"mass_flow": 0.01, "temperature": 300.0, "height": 0.2, "width": 0.05},
        },
    },
    "tubes": {"perimeter": 4.0, "coefficient": "molerus_wirth", "temperature": 550.0, "emissivity": 0.8},
    "distributor": {"coefficient": 80.0, "preheat_NTU": 2.5, "emissivity": 0.8},
    "freeboard": {"temperature": 900.0},
    "radiation": {"level": "p1"},
    "output": {"plots": False, "fields": False},
}  # fmt: skip


def tables(**changes):
    """The tables of a hot bed; a dotted key replaces one value, a table all of a table, None removes it."""
    found = deepcopy(HOT)
    for key, value in changes.items():
        *path, last = key.split("__")
        table = found
        for step in path:
            table = table[step]
        if value is None:
            table.pop(last, None)
        else:
            table[last] = value
    return found


def hot(**changes):
    """A scene of a hot bed, with changes as in `tables`."""
    return from_dict(tables(**changes))
