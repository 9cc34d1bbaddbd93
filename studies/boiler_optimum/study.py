"""The boiler that earns most at 850 degC, kept at a distance from the tubes that put
it out.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
DESIGN = HERE / "design" / "boiler.toml"
DISTANCES = (0.25, 0.20)  # share of tubes more that put the bed out
STARTS = {
    "bubbling_bed.tubes.perimeter": "tubes_m",
    "boundary.bottom.gas.mass_flow": "air_kg_s",
    "solids.stone.diameter": "stone_m",
    "solids.stone.feed.mass_flow": "limestone_kg_s",
}
NOT_COMPARED = ("evaluations",)


def reference() -> float:
    """Temperature at which such beds are run [degC]."""
    return 850.0


def compute() -> Tables:
    """The optimum and the prices of its constraints for each distance, each search
    from the optimum before.
    """
    rows: list[dict[str, Any]] = []
    for distance in DISTANCES:
        with TemporaryDirectory() as folder:
            rows.append(optimum(distance, rows[-1] if rows else None, Path(folder)))
    return {"optimum": Table.of(rows, ".7g")}


def optimum(
    distance: float, before: dict[str, Any] | None, folder: Path
) -> dict[str, Any]:
    """Row of the optimum with a distance to extinction; runs are kept in `folder`."""
    from contbed.many.optimise.optimise import optimise

    text = DESIGN.read_text(encoding="utf-8").replace(
        "fold_distance >= 0.25", f"fold_distance >= {distance:g}"
    )
    text = text.replace("../boiler.toml", str(HERE / "boiler.toml"))
    for key, column in STARTS.items() if before is not None else ():
        assert before is not None
        line = next(line for line in text.splitlines() if line.startswith(key))
        text = text.replace(
            line, line.replace(" }", f", start = {before[column]:.6g} }}")
        )
    file = folder / "design.toml"
    file.write_text(text, encoding="utf-8")
    done = optimise(file, folder / "out")
    point = dict(zip(STARTS.values(), done.found.evaluation.point, strict=True))
    qoi = done.found.evaluation.qoi
    prices = dict(
        zip(
            ("price_temperature", "price_capture", "price_distance"),
            done.found.prices,
            strict=True,
        )
    )  # EUR/h per K and per 1
    return {
        "distance": distance,
        **point,
        "earned_EUR_h": done.design.objective(
            {**qoi, "solids.stone.feed.mass_flow": point["limestone_kg_s"]}
        ),
        "tubes_MW": 1e-6 * (qoi["tubes_convection_W"] + qoi["tubes_radiation_W"]),
        "T_bed_C": qoi["T_ash_mid_K"] - 273.15,
        "capture": qoi["sulphur_capture"],
        "fold_m": qoi["fold_1"],
        **prices,
        "price_stone": done.found.bound_prices[2],
        "converged": int(done.found.status == "optimum"),
        "evaluations": len(done.evaluations),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """What is earned and how many tubes, over the distance; a price is what one unit
    less of the distance earns.
    """
    table = tables["optimum"]
    figure, (left, right) = gallery.figure(1, 2, size=(9, 3.6))
    distance, earned, price = (
        table[name] for name in ("distance", "earned_EUR_h", "price_distance")
    )
    left.plot(100.0 * distance, earned, "o", color=gallery.BLUE, label="optimum")
    for k, (at, value, slope) in enumerate(zip(distance, earned, price, strict=True)):
        ends = at + np.array([-0.012, 0.012])
        label = "slope by its price" if k == 0 else None
        left.plot(
            100.0 * ends,
            value - slope * (ends - at),
            "-",
            color=gallery.VERMILION,
            label=label,
        )
    left.set(xlabel="tubes to extinction [% more]", ylabel="earned [EUR/h]")
    left.legend()
    right.plot(
        100.0 * distance,
        1.2 * table["tubes_m"],
        "o-",
        color=gallery.BLUE,
        label="chosen",
    )
    right.plot(
        100.0 * distance,
        1.2 * table["fold_m"],
        "s--",
        color=gallery.VERMILION,
        label="at which it goes out",
    )
    right.set(xlabel="tubes to extinction [% more]", ylabel="tubes in the bed [m2]")
    right.legend()
    return {"optimum": figure}
