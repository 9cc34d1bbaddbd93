"""Coefficients of a bubbling bed as numbers, from which its layers are predicted
before there is a mesh.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, NoReturn

import numpy as np

from contbed.bubbling_bed.coefficients import Computed
from contbed.errors import SceneError

QUOTED = {
    "u": "m/s",
    "u_mf": "m/s",
    "u_e": "m/s",
    "u_b": "m/s",
    "d_b": "m",
    "delta": "",
}
COEFFICIENTS = {
    "delta": "the volume of the bubbles",
    "gas": "heat transfer to the gas",
    "conduction": "axial mixing",
    "pairs": "heat exchange between solid phases",
    "exchange": "heat exchange of the bubbles",
    "contact": "heat transfer to surfaces",
    "flows": "the flow",
}


def frozen(computed: Computed, T: float, height: float) -> dict[str, Any]:
    """Return the coefficients half way up a bed of one temperature [K] and a
    height [m].

    Raises
    ------
    SceneError : names the coefficient that has no value there
    """
    at: dict[str, Any] = {
        f"T_{name}": np.full(1, T) for name in (*computed.names, "emulsion", "bubble")
    }
    if computed.bubbling:
        flows, sizes = computed.march(T, np.array([0.0, 0.5 * height]))
        at |= {"flow_bubble": flows[1:], "d_bubble": sizes[1:]}
    o = SimpleNamespace(grad=lambda field: (0.0,), x=(np.full(1, 0.5 * height),))
    with np.errstate(invalid="ignore"):  # values that are not finite are reported below
        local = computed(SimpleNamespace(**at), o)
    cp = {name: local.heat_capacity[name](T) for name in local.flows}

    def number(value: Any) -> float:
        return float(np.squeeze(value))

    found: dict[str, Any] = {
        "delta": number(local.delta),
        "gas": {n: number(v) for n, v in local.gas.items()},
        "conduction": {n: number(v) for n, v in local.conduction.items()},
        "pairs": {n: number(v) for n, v in local.pairs.items()},
        "exchange": number(local.exchange),
        "contact": {n: number(v) for n, v in local.contact.items()},
        "flows": {n: number(v * cp[n]) for n, v in local.flows.items()},
    }
    for key, value in found.items():
        for name, each in value.items() if isinstance(value, dict) else (("", value),):
            if not np.isfinite(each):
                _refuse(
                    computed,
                    T,
                    key,
                    name,
                    {k: number(v) for k, v in local.state.items() if np.size(v) == 1},
                )
    return found


def _refuse(
    computed: Computed, T: float, key: str, name: Any, state: dict[str, float]
) -> NoReturn:
    """Name the coefficient that has no value at the temperature at which layers are
    predicted.
    """
    of = (
        f" of {' and '.join(name) if isinstance(name, tuple) else name}" if name else ""
    )
    known = ", ".join(
        f"{k} = {state[k]:.3g} {unit}" for k, unit in QUOTED.items() if k in state
    )
    raise SceneError(
        f"{computed.scene.origin.at(('solids',))}: {COEFFICIENTS[key]}{of} has no "
        f"value in a bed of {T:g} K, where "
        f"{known}; choose other closures, or change boundary.bottom.gas.mass_flow"
    )
