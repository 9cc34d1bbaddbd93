"""Gas properties: accuracy against Cantera and time per point, for all four properties of several mixtures.

python studies/gas_properties/study.py        # writes gas_properties.csv
"""

from __future__ import annotations

import time
from pathlib import Path

import cantera
import numpy as np

from contbed.materials import gas_mixture

MIXTURES = {
    "nitrogen": "N2:1",
    "steam": "H2O:1",
    "air": "N2:0.79, O2:0.21",
    "syngas": "CO:0.2, CO2:0.1, H2:0.2, H2O:0.1, CH4:0.05, N2:0.35",
}
PROPERTIES = {
    "density": lambda gas: gas.density_mass,
    "heat_capacity": lambda gas: gas.cp_mass,
    "viscosity": lambda gas: gas.viscosity,
    "conductivity": lambda gas: gas.thermal_conductivity,
}
POINTS = 100_000
REPEATS = 7


def best_time(function, *arguments) -> float:
    """Least wall time of several calls [s]."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        function(*arguments)
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    """Compare on 301 temperatures, time on 1e5."""
    many = np.random.default_rng(0).uniform(300.0, 3000.0, POINTS)
    few = np.linspace(300.0, 3000.0, 301)
    rows = ["mixture,property,largest relative difference [1],time [ns/point],time of Cantera [ns/point]"]
    for name, composition in MIXTURES.items():
        gas, peer = gas_mixture(composition, cantera.one_atm), cantera.Solution("gri30.yaml")

        def loop(get, temperatures, peer=peer, composition=composition):
            out = np.empty(len(temperatures))
            for i, T in enumerate(temperatures):
                peer.TPX = T, cantera.one_atm, composition
                out[i] = get(peer)
            return out

        for quantity, get in PROPERTIES.items():
            ours = getattr(gas, quantity)
            difference = np.max(np.abs(ours(few) / loop(get, few) - 1.0))
            mine, theirs = best_time(ours, many) / POINTS, best_time(loop, get, few) / len(few)
            rows.append(f"{name},{quantity},{difference:.1e},{1e9 * mine:.1f},{1e9 * theirs:.0f}")
    Path(__file__).with_name("gas_properties.csv").write_text("\n".join(rows) + "\n", encoding="ascii")
    print("\n".join(rows))


if __name__ == "__main__":
    main()
