"""Time and error of the level inside of particles that the plan takes, beside each
fixed one, over 200 random beds.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.packed_bed.inside import Candidate
from contbed.packed_bed.plan import plan
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
NOT_COMPARED = ("CPU [s]", "CPU over film alone")
BEDS, SEED = 200, 1
AT_REST, AGAINST, ALONG, STEADY = (
    "at rest in time",
    "steady, against",
    "steady, along",
    "steady at rest",
)
KINDS = (AT_REST, AGAINST, ALONG, STEADY)
FIXED = ("lumped", "effective", "3 points", "8 points")
REFERENCE = "16 points"
ACCURACIES = (0.05, 5e-3, 5e-4)  # of the choice; the second is the default
# times of the breakthrough over its mean, after the arrival of the gas
OUTPUT = np.linspace(0.05, 1.5, 24)
HOLD = 1e-3  # heat held by the gas over that of the solids
FLOOR = 1e-5  # error below which a point is drawn at this value


def bed(kind: str, random: np.random.Generator) -> dict[str, Any]:
    """Tables of one random bed of length 1 m; Biot numbers, transfer units and stays
    are drawn over decades.
    """
    scene = tomllib.loads((HERE / "bed.toml").read_text(encoding="utf-8"))
    biot, units = 10.0 ** random.uniform(-1.5, 1.5), 10.0 ** random.uniform(0.0, 1.7)
    fourier, gamma = 10.0 ** random.uniform(-1.5, 0.5), random.uniform(0.3, 1.5)
    axial, through = 10.0 ** random.uniform(-3.0, -1.5, 2) * [1.0, 30.0]
    s = 3 if random.random() < 0.7 else 2
    solid, gas, porosity = (
        scene["solids"]["particles"],
        scene["gas"],
        scene["packed_bed"]["porosity"],
    )
    d, share = solid["diameter"], 1.0 - porosity
    film = scene["closures"]["nusselt"] * gas["conductivity"] / d
    capacity = solid["density"] * solid["heat_capacity"]
    solid["shape"] = "spheres" if s == 3 else "rods"
    solid["conductivity"] = film * 0.5 * d / biot
    if kind in (AGAINST, ALONG):
        units = s * gamma * biot * fourier
    carried = film * 2 * s * share / d / units  # heat capacity flow of the gas [W/m2/K]
    held = HOLD * share * capacity / porosity
    gas["density"] = held / gas["heat_capacity"]
    scene["closures"]["conductivity_gas"] = float(axial * carried)
    scene["boundary"]["left"]["gas"]["velocity"] = carried / held
    mean = share * capacity / carried
    scene["time"] |= {
        "end": float(OUTPUT[-1] * mean),
        "times": [float(t * mean) for t in OUTPUT],
    }
    if kind != AT_REST:
        del scene["time"], scene["initial"]
    if kind == STEADY:  # the solids are held cold where the gas leaves
        scene["closures"]["conductivity_solids"] = float(through * carried)
        scene["boundary"]["right"] = {
            "solids": {"particles": {"fixed_temperature": 300.0}}
        }
    if kind in (AGAINST, ALONG):
        entering = scene["boundary"].pop("left")
        solids = {"velocity": gamma * carried / capacity, "temperature": 300.0}
        scene["boundary"]["left"] = {"solids": {"particles": solids}}
        if kind == AGAINST:
            scene["boundary"]["right"] = entering
        else:
            scene["boundary"]["left"] |= entering
    return scene


def at(scene: dict[str, Any], level: str) -> Any:
    """Return the scene with a level by its name in the tables."""
    points, _, named = level.partition(" ")
    table = {"heat": "interior", "points": int(points)} if named else {"heat": level}
    solid = scene["solids"]["particles"] | {"inside": table}
    return cb.load(scene | {"solids": {"particles": solid}})


def leaving(result: Any) -> Any:
    """Temperatures of what leaves over the span: of the gas at the output times, or
    of both phases of a steady bed.
    """
    if "t [s]" not in result.profiles:
        names = [f"T_{phase}_out_K" for phase in ("fluid", "solid")]
        return (
            np.array([result.qoi[name] for name in names if name in result.qoi]) / 100.0
        )
    times, T = result.profiles["t [s]"], result.profiles["T_fluid [K]"]
    return np.array([T[times == t][-1] for t in np.unique(times)[1:]]) / 100.0


def reference(scene: dict[str, Any]) -> Any:
    """Temperatures of what leaves with many points inside."""
    return leaving(cb.run(at(scene, REFERENCE)))


def name(chosen: Candidate) -> str:
    """Return the level as the tables call it."""
    return f"{chosen.points} points" if chosen.points else chosen.level


def compute() -> Tables:
    """Predicted and true errors and CPU of all levels of each bed, and the medians
    of each way to choose.
    """
    random = np.random.default_rng(SEED)
    rows, choices = [], []
    for number in range(BEDS):
        kind = KINDS[number % len(KINDS)]
        scene = bed(kind, random)
        exact = reference(scene)
        taken = []
        for accuracy in ACCURACIES:
            found = plan(cb.load(scene | {"solver": {"accuracy": accuracy}})).inside
            taken.append(name(found.chosen))
        for level in dict.fromkeys([*FIXED, *taken]):
            chosen = plan(at(scene, level)).inside
            passage = chosen.passage
            seconds, result = gallery.cpu(
                lambda level=level, scene=scene: cb.run(at(scene, level)), samples=1
            )
            error = float(np.abs(leaving(result) - exact).max())
            rows.append([number, kind, passage.biot, passage.units, passage.fourier, level, chosen.chosen.error, error,
                         seconds])  # fmt: skip
        choices.append([number, kind, *taken])
    columns = {
        "bed": "d",
        "kind": "",
        "Bi": ".4g",
        "units": ".4g",
        "Fo": ".4g",
        "level": "",
        "predicted": ".3e",
    }
    columns |= {"error": ".3e", "CPU [s]": ".3f"}
    chosen_columns = {"bed": "d", "kind": ""} | {
        f"accuracy {accuracy:g}": "" for accuracy in ACCURACIES
    }
    tables = {
        "results": Table(columns, rows),
        "choices": Table(chosen_columns, choices),
    }
    return tables | {"summary": summary(tables)}


def summary(tables: Tables) -> Table:
    """Errors over all beds and mean CPU of each fixed level and of the choice at
    each accuracy.
    """
    found = {
        (int(r["bed"]), r["level"]): (float(r["error"]), float(r["CPU [s]"]))
        for r in tables["results"]
    }
    beds = list(tables["choices"])
    ways = {level: [found[int(b["bed"]), level] for b in beds] for level in FIXED}
    for accuracy in ACCURACIES:
        key = f"accuracy {accuracy:g}"
        ways[f"plan, {key}"] = [found[int(b["bed"]), b[key]] for b in beds]
    lumped = sum(cpu for _, cpu in ways["lumped"])
    rows = []
    for way, pairs in ways.items():
        errors = np.array([error for error, _ in pairs])
        total = sum(cpu for _, cpu in pairs)
        above = [100.0 * float((errors > limit).mean()) for limit in ACCURACIES]
        rows.append(
            [
                way,
                float(np.median(errors)),
                float(errors.max()),
                *above,
                total / len(pairs),
                total / lumped,
            ]
        )
    columns = {"way": "", "median error": ".1e", "largest error": ".1e"}
    columns |= {f"above {limit:g} [%]": ".1f" for limit in ACCURACIES}
    return Table(columns | {"CPU [s]": ".2f", "CPU over film alone": ".2f"}, rows)


def plot(tables: Tables) -> dict[str, Any]:
    """True over predicted errors, and the largest error of each way over its CPU."""
    figure, (left, right) = gallery.figure(1, 2, size=(10.5, 4.4))
    colours = dict(
        zip(
            FIXED,
            (gallery.GREY, gallery.BLUE, gallery.GREEN, gallery.PURPLE),
            strict=True,
        )
    )
    for level, colour in colours.items():
        here = tables["results"].where({"level": level})
        x, y = (np.maximum(here[key], FLOOR) for key in ("predicted", "error"))
        left.loglog(x, y, "o", color=colour, markersize=3, alpha=0.7, label=level)
    left.plot([FLOOR, 1.0], [FLOOR, 1.0], color="k", linewidth=0.8)
    left.set(
        xlabel="predicted error",
        ylabel="error against 16 points inside",
        title="what leaves, over the span",
    )
    left.legend(loc="upper left")
    for row in tables["summary"]:
        planned = row["way"].startswith("plan")
        x, y = float(row["CPU over film alone"]), float(row["largest error"])
        colour = gallery.VERMILION if planned else colours[row["way"]]
        right.semilogy([x], [y], "D" if planned else "o", color=colour, markersize=7)
        gallery.label_line(
            right, row["way"].replace("plan, accuracy", "plan"), x, y, colour, (8, 0)
        )
    right.set(
        xlabel="CPU of all beds over that of the film alone",
        ylabel="largest error of all beds",
    )
    right.margins(x=0.3)
    return {"levels": figure}
