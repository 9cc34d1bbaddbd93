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
    capacities = local.heat_capacity
    local.flows = {
        name: flow * capacities[name](T) for name, flow in local.flows.items()
    }
    found: dict[str, Any] = {}
    for key in COEFFICIENTS:
        value = getattr(local, key)
        several = isinstance(value, dict)
        numbers = {
            name: float(np.squeeze(each))
            for name, each in (value if several else {"": value}).items()
        }
        for name, number in numbers.items():
            if not np.isfinite(number):
                _refuse(computed, T, key, name, local.state)
        found[key] = numbers if several else numbers[""]
    return found


def _refuse(
    computed: Computed, T: float, key: str, name: Any, state: dict[str, Any]
) -> NoReturn:
    """Name the coefficient that has no value at the temperature at which layers are
    predicted.
    """
    of = (
        f" of {' and '.join(name) if isinstance(name, tuple) else name}" if name else ""
    )
    known = ", ".join(
        f"{k} = {float(np.squeeze(state[k])):.3g} {unit}"
        for k, unit in QUOTED.items()
        if k in state
    )
    raise SceneError(
        f"{computed.scene.origin.at(('solids',))}: {COEFFICIENTS[key]}{of} has no "
        f"value in a bed of {T:g} K, where "
        f"{known}; choose other closures, or change boundary.bottom.gas.mass_flow"
    )
