"""Random bubbling beds with computed coefficients: every table, closure and property
that a scene may combine.

A seed gives one scene. Gas enters at 1.2 to 12 times minimum fluidization, as the
closure of the scene gives it.
"""

from types import SimpleNamespace

import numpy as np

from contbed.bubbling_bed.scene_coefficients import computed_of
from contbed.loading import from_dict
from tests.scene_text import set_keys

GASES = (
    "N2:0.79, O2:0.21",
    "N2:1.0",
    "CO2:0.15, H2O:0.1, N2:0.75",
    "H2:1.0",
    "H2O:0.6, CO:0.2, H2:0.2",
    "AR:1.0",
)
FLUIDIZATION = ("grace", "wen_yu", "richardson", "saxena_vogel", "babu", "chitester")
AREA = 1e-3  # of the distributor for one orifice [m2]


def tables(seed):
    """Return the tables of one bed."""
    rng = np.random.default_rng(seed)

    def log(low, high):
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def pick(*choices):
        return choices[rng.integers(len(choices))]

    def perhaps(share):
        return rng.random() < share

    height, section = log(0.2, 3.0), log(0.01, 20.0)
    kinds = [
        "inert",
        *(["char"] if perhaps(0.6) else []),
        *(["lime"] if perhaps(0.3) else []),
    ]
    small = {name: log(1e-3, 0.2) for name in kinds[1:]}
    shares = {"inert": 1.0 - sum(small.values()), **small}
    bubbling = perhaps(0.85)
    solids = {}
    for name in kinds:
        mixing = log(1e1, 1e5)
        solids[name] = {
            "volume_share": shares[name],
            "diameter": log(1e-4, 1.5e-3) if name == "inert" else log(2e-4, 6e-3),
            "density": log(800.0, 4000.0),
            "heat_capacity": pick(
                log(600.0, 1500.0), [log(500.0, 1000.0), log(0.05, 0.6)]
            ),
            "conductivity": log(0.2, 30.0),
            "sphericity": float(rng.uniform(0.6, 1.0)),
            "emissivity": float(rng.uniform(0.2, 0.95)),
        }
        to_gas = pick("gunn", "ranz_marshall", "kunii_levenspiel", log(30.0, 1000.0))
        solids[name]["nusselt" if isinstance(to_gas, str) else "gas_coefficient"] = (
            to_gas
        )
        solids[name]["mixing_conductivity"] = (
            pick("kunii_levenspiel", mixing) if bubbling else mixing
        )
        if name != "inert":
            if perhaps(0.7):
                solids[name]["exchange"] = {
                    "inert": pick("agu", log(1e2, 1e6)) if bubbling else log(1e2, 1e6)
                }
            if perhaps(0.7):
                solids[name]["feed"] = {
                    "mass_flow": 1e-3 * section * log(0.1, 30.0),
                    "temperature": log(290.0, 1000.0),
                    "height": height * float(rng.uniform(0.0, 1.0)),
                    "width": height * log(0.02, 0.3),
                    "drain": pick("top", "bottom"),
                }
    given = {
        "bubbling_bed": {
            "height": height,
            "section": section,
            "solids_fraction": float(rng.uniform(0.4, 0.6)),
        },
        "closures": {
            "minimum_fluidization": "minimum_fluidization_" + pick(*FLUIDIZATION)
        },
        "gas": {
            "composition": pick(*GASES),
            "pressure": pick(101325.0, 101325.0, log(1e5, 3e6)),
        },
        "boundary": {
            "bottom": {"gas": {"mass_flow": 1.0, "temperature": log(290.0, 1100.0)}}
        },
        "solids": solids,
        "initial": {"temperature": float(rng.uniform(500.0, 1600.0))},
        "output": {"plots": False, "fields": False},
    }
    bed, inlet = given["bubbling_bed"], given["boundary"]["bottom"]["gas"]
    if perhaps(0.3):
        bed["conductivity"] = pick("kunii_smith", "krupiczka", log(0.1, 2.0))
    if bubbling:
        start = pick("porous_plate", "orifices", "darton")
        bed["bubbles"] = {
            "fraction": pick(
                "kunii_levenspiel", "two_phase", float(rng.uniform(0.05, 0.4))
            ),
            "exchange": pick("kunii_levenspiel", "sit_grace", log(1e2, 1e5)),
            "size": pick("mori_wen", "horio_nonaka", "darton", height * log(0.01, 0.3)),
            "start": start
            if start == "porous_plate"
            else {"name": start, "area": AREA},
            "emulsion_gas": pick("two_phase", "two_phase", "kunii_levenspiel"),
        }
    surfaces = ("zabrodsky", "molerus_wirth", "molerus_laminar")
    for name in ("tubes", "walls"):
        if perhaps(0.5):
            bed[name] = {
                "perimeter": section / height * log(1.0, 50.0),
                "coefficient": pick(*surfaces, log(50.0, 800.0)),
                "temperature": float(rng.uniform(300.0, 1000.0)),
                "emissivity": float(rng.uniform(0.3, 0.95)),
            }
    if perhaps(0.5):
        bed["distributor"] = {
            "coefficient": log(10.0, 500.0),
            "preheat_NTU": log(0.1, 5.0),
            "emissivity": float(rng.uniform(0.3, 0.9)),
        }
    if perhaps(0.2):
        bed["settled_height"] = bed.pop("height")
        if bubbling and perhaps(0.3):
            set_keys(given, 'closures.expansion = "souza_santos"')
    if perhaps(0.2):
        bed["freeboard"] = {
            "height": log(0.5, 5.0),
            "temperature_above": float(rng.uniform(400.0, 1300.0)),
        }
    elif perhaps(0.5):
        bed["freeboard"] = {"temperature": float(rng.uniform(400.0, 1300.0))}
    if "tubes" in bed and perhaps(0.2):
        bed["tubes"].pop("temperature")
        bed["tubes"]["steam"] = {
            "pressure": log(1e6, 1e7),
            "temperature": 400.0,
            "mass_flow": section * log(0.01, 1.0),
            "coefficient": log(500.0, 5000.0),
        }
    given["radiation"] = {
        "level": pick("none", "p1", "p1", "two_flux", "paper", "pairwise")
    }
    inlet["mass_flow"] = _fluidizing(given, log(1.2, 12.0))
    # heat that warms the gas by up to some 1500 K; a little of it is released in the
    # gas or the first species
    heat = inlet["mass_flow"] * 1100.0 * float(rng.uniform(-50.0, 1200.0))
    if "tubes" in bed or "walls" in bed:
        heat *= log(1.0, 3.0)
    release = {"rate": heat / (section * height)}
    if perhaps(0.5):
        release["length"] = height * log(0.1, 1.0)
        release["rate"] /= (
            release["length"] / height * -np.expm1(-height / release["length"])
        )
    if perhaps(0.15):
        release |= {
            "activation": float(rng.uniform(1e3, 12e3)),
            "reference": float(rng.uniform(700.0, 1200.0)),
        }
    if "char" in solids and perhaps(0.6):
        solids["char"]["release"] = release
    else:
        pick(bed, solids["inert"])["release"] = release
    return given


def _fluidizing(given, excess):
    """Return the flow [kg/s] of gas at `excess` times minimum fluidization at the
    temperature of the guess.
    """
    scene = from_dict(given)
    computed = computed_of(scene)
    names = {f"T_{name}": scene.initial.temperature for name in scene.present}
    state, _ = computed.state(SimpleNamespace(**names), 1.0)
    return float(excess * state["rho_gas"] * state["u_mf"] * scene.bubbling_bed.section)
