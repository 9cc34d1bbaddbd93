"""Steel beads heated from above in air at rest (Beaulieu 2020): conductivity from a
packing, effect by effect.
"""

from __future__ import annotations

import gzip
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed import closures
from contbed.closures.file import closure_of
from contbed.dem import extract, heat, network
from contbed.dem.heat_pair import column_conductance, correction
from contbed.dem.packing import pack
from contbed.dem.particles import Material
from contbed.dem.surface import Surface
from contbed.many.cascade.outcome import Outcome
from contbed.many.cascade.run import cascade
from contbed.many.validate import case, score
from contbed.runner import run
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
PACKING, CLOSURE = HERE / "packing.csv.gz", HERE / "closures/conductivity.toml"
NAME = "beaulieu_2020"
# a difference of two of the columns that are compared
NOT_COMPARED = ("half width",)
R, K_SOLID, K_GAS, MODULUS = 3.2e-3, 42.0, 0.027, 2e11
WIDTH, COUNT, HEIGHT = (0.1, 0.105), 8849, 0.198
AREA = WIDTH[0] * WIDTH[1]
POROSITY = 0.42  # measured
# a bed of density 1000 and modulus E/7.747 moves as one of steel with modulus E
LIGHT, DENSITY = 1000.0, 7747.0
# modulus with which beds settle, 1 GPa for steel; contacts are corrected
SETTLED = 1.29e8 * DENSITY / LIGHT
FRICTION = (0.2, 0.4, 0.7)  # the middle one gives the measured porosity and height
# depths below the surface of the bed between which heat is measured [m]
TOP, BOTTOM = 0.01, 0.10
BELOW = 0.015  # of the beads that are held at one temperature below the lower depth [m]
RATIOS = (800.0, 1100.0, K_SOLID / K_GAS, 2200.0, 3000.0)
SURFACE = Surface(19e-9, 0.056, 3e9, MODULUS, 0.29, 68e-9, accommodation=0.7)
EMISSIVITY, T_MEAN = 0.3, 303.0
ASKED = 20.8  # k/k_gas that the points ask for, with the stated heat capacity
# spreading columns are so much below a resolved simple cubic lattice at this ratio
LAW = 0.02
# lower and upper value of each input, about one standard deviation to both sides where
# the source states none
SPREAD: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "accommodation 0.6 to 0.9": ({"accommodation": 0.6}, {"accommodation": 0.9}),
    "roughness 10 to 38 nm": ({"roughness": 38e-9}, {"roughness": 10e-9}),
    "slope 0.04 to 0.07": ({"slope": 0.04}, {"slope": 0.07}),
    "microhardness 2 to 4 GPa": ({"microhardness": 4e9}, {"microhardness": 2e9}),
    "contact forces times 1/2 to 2": ({"load": 0.5}, {"load": 2.0}),
    "conductivity of steel 38 to 46 W/m/K": ({"k": 38.0}, {"k": 46.0}),
    "emissivity 0.1 to 0.6": ({"emissivity": 0.1}, {"emissivity": 0.6}),
}


@dataclass(frozen=True)
class Bed:
    """Centres [m] of a settled bed, porosity of its box, height of its surface [m];
    its upper part conducts.
    """

    x: Any
    porosity: float
    surface: float

    @cached_property
    def kept(self) -> Any:
        """Centres of the upper part."""
        return self.x[self.x[:, 2] > self.surface - BOTTOM - BELOW]

    @cached_property
    def pairs(self) -> heat.Pairs:
        """Pairs of the upper part that share a Voronoi face."""
        low = np.array([0.0, 0.0, self.surface - BOTTOM - BELOW])
        return heat.voronoi_pairs(
            self.kept, (low, np.array([*WIDTH, self.x[:, 2].max() + R]))
        )

    def conductivity(
        self, parts: dict[str, Any], pairs: heat.Pairs | None = None
    ) -> tuple[float, dict[str, float]]:
        """k/k_gas between the layers, and the shares of the mechanisms."""
        z = self.kept[:, 2]
        cold, hot = z < self.surface - BOTTOM, z > self.surface - TOP
        found = network.between_layers(
            self.kept, pairs or self.pairs, parts, hot, cold, AREA
        )
        return found.conductivity / K_GAS, found.shares

    def spreading(
        self,
        k: float = K_SOLID,
        load: float = 1.0,
        contact: bool = True,
        rough: bool = True,
        emissivity: float = EMISSIVITY,
        **surface: float,
    ) -> float:
        """k/k_gas along spreading paths."""
        factor = contact * float(correction(SETTLED, MODULUS)) * load ** (1 / 3)
        faces = SURFACE._replace(**surface) if rough else None
        how = heat.Conduction(
            k, K_GAS, POROSITY, factor, paths="spreading", surface=faces
        )
        parts = heat.conductances(self.pairs, R, how)
        if emissivity:
            parts["radiation"] = heat.radiation_conductance(
                self.pairs, len(self.kept), T_MEAN, 2 * R, emissivity, POROSITY
            )
        return self.conductivity(parts)[0]


def settle(friction: float, seed: int = 1) -> Bed:
    """Settle a bed of the experiment's size and number of beads."""
    material = Material(LIGHT, SETTLED * LIGHT / DENSITY, 0.29, 0.8, friction, 0.02)
    bed = pack(WIDTH, radius=R, count=COUNT, seed=seed, material=material)
    return Bed(bed.position, bed.statistics["porosity_box"], bed.statistics["surface"])


def store(bed: Bed) -> None:
    """Write centres to 10 nm, a hundredth of an overlap; the time stamp of the
    archive is left out.
    """
    lines = "\n".join(",".join(f"{value:.8f}" for value in row) for row in bed.x)
    PACKING.write_bytes(gzip.compress(lines.encode(), mtime=0))


def effects(bed: Bed) -> Table:
    """k/k_gas of one bed, one effect after the other."""
    factor = float(correction(SETTLED, MODULUS))
    near = heat.near_pairs(bed.kept, 3 * R)
    cones = heat.conductances(
        near, R, heat.Conduction(K_SOLID, K_GAS, POROSITY, factor)
    )
    apart, face = np.maximum(bed.pairs.distance, 2 * R), bed.pairs.face
    assert face is not None
    columns = {"fluid": column_conductance(R, apart, face, K_SOLID, K_SOLID, K_GAS)}
    # asperities of 1 pm: a perfect joint
    smooth = bed.spreading(emissivity=0.0, roughness=1e-12)
    steps = [
        (
            "cones, Eq. 5 of Zhou et al., with smooth contacts",
            bed.conductivity(cones, near)[0],
        ),
        ("parallel columns, point contacts", bed.conductivity(columns)[0]),
        (
            "heat spreads within the beads, point contacts",
            bed.spreading(contact=False, rough=False, emissivity=0.0),
        ),
        (
            "and temperature jump of the gas (Smoluchowski)",
            bed.spreading(contact=False, emissivity=0.0),
        ),
        ("and Hertz contacts under the weight, smooth", smooth),
        ("and roughness of the contacts", bed.spreading(emissivity=0.0)),
        ("and radiation", bed.spreading()),
    ]
    values = [value for _, value in steps]
    changes = [None, None, *np.diff(values[1:])]
    rows = [(name, k, change) for (name, k), change in zip(steps, changes, strict=True)]
    return Table({"effect": "", "k/k_gas": ".2f", "change": ".2f"}, rows)


def band(bed: Bed, slope: float, residual: float) -> Table:
    """Changes of k/k_gas with each input; `slope` and `residual` are those of the
    closure.
    """
    base = bed.spreading()
    rows: list[tuple[Any, ...]] = [("as stated", base, base, 0.0)]
    for name, (low, high) in SPREAD.items():
        k = bed.spreading(**low), bed.spreading(**high)
        rows.append((name, *k, 0.5 * abs(k[1] - k[0])))
    for name, share in (
        ("porosity 0.41 to 0.43", -0.01 * slope),
        ("packing", residual),
        ("law", LAW),
    ):
        rows.append((name, base * (1 - share), base * (1 + share), base * abs(share)))
    whole = float(np.sqrt(np.sum([row[3] ** 2 for row in rows])))
    rows.append(("all together", base - whole, base + whole, whole))
    return Table({"input": "", "low": ".2f", "high": ".2f", "half width": ".2f"}, rows)


def fit(beds: Sequence[Bed]) -> extract.Fit:
    """ln(k/k_gas) over ratio and porosity, each linear."""
    data = [
        (ratio, bed.porosity, bed.spreading(k=ratio * K_GAS))
        for bed in beds
        for ratio in RATIOS
    ]
    ratio, eps, k = np.array(data).T
    scales = {extract.RATIO: "log", "eps": "linear"}
    return extract.fit_log_polynomial(
        "conductivity", {extract.RATIO: ratio, "eps": eps}, k, scales, (1, 1)
    )


def reference() -> Any:
    """Measured points: times [s], depths [m], temperatures [K]."""
    return case.read_case(NAME).points


def temperatures(conductivity: Any, t: Sequence[float], x: Sequence[float]) -> Any:
    """Predicted temperatures [K] at times and depths (points,), with a closure or a
    value in W/m/K.
    """
    changes = {
        "closures.conductivity_solids": conductivity,
        "time.times": sorted(set(t)),
        "time.end": max(t),
    }
    places = {"output.positions": sorted(set(x))}
    result = run(
        cb.load(
            HERE / "beaulieu.toml",
            {**changes, **places, "output.plots": False, "output.fields": False},
        )
    )
    return score.at(case.read_case(NAME), result, np.asarray(t), np.asarray(x))


def scored(conductivities: dict[str, Any]) -> Table:
    """RMS and bias [K] at each depth, and temperatures at 0.073 m."""
    points = reference()
    rows = []
    for name, k in conductivities.items():
        E = temperatures(k, points.t.tolist(), points.x.tolist()) - points.value
        each = [E[points.x == x] for x in np.unique(points.x)]
        errors = [value for e in each for value in (np.sqrt(np.mean(e**2)), np.mean(e))]
        times = [1000.0, 2000.0, 3000.0, 4000.0]
        ahead = temperatures(k, times, [0.073] * 4)
        rows.append((name, *errors, *ahead))
    depths = [
        f"{what} at {x:g} m [K]"
        for x in np.unique(points.x)
        for what in ("RMS", "bias")
    ]
    late = [f"T at 0.073 m, {t} s [K]" for t in (1000, 2000, 3000, 4000)]
    return Table(
        {
            "conductivity": "",
            **dict.fromkeys(depths, ".2f"),
            **dict.fromkeys(late, ".2f"),
        },
        rows,
    )


def curves(half: float) -> Table:
    """Temperatures [K] at the three depths over time, with the closure and at both
    ends of the band.
    """
    t = np.arange(100.0, 4001.0, 100.0)
    columns: dict[str, Any] = {"t [s]": t}
    for x in (0.04, 0.06, 0.073):
        for name, k in (
            ("", middle()),
            (", low", middle() - half),
            (", high", middle() + half),
        ):
            columns[f"{x:g} m{name} [K]"] = temperatures(
                K_GAS * k, t.tolist(), [x] * len(t)
            )
    return Table.from_columns(columns, ".6g")


def middle() -> float:
    """k/k_gas of the closure at the stated inputs."""
    found = closure_of(CLOSURE.name, CLOSURE.parent, "conductivity")
    return float(found(k_solid=K_SOLID, k_fluid=K_GAS, eps=POROSITY)) / K_GAS


def cascaded(found: Outcome) -> list[tuple[str, str, float]]:
    """Shares of the measured points that the band of a cascade holds [-], and of
    each part in the variance at them.
    """
    held = found.held
    assert held is not None
    rows: list[tuple[str, str, float]] = []
    for x in np.unique(held.points.x):
        here = held.points.x == x
        value = held.points.value[here]
        inside = (held.low[here] <= value) & (value <= held.high[here])
        scattered = (held.low_measured[here] <= value) & (
            value <= held.high_measured[here]
        )
        rows.append(("points in the band", f"{x:g} m", float(inside.mean())))
        rows.append(
            ("points in the band of a measurement", f"{x:g} m", float(scattered.mean()))
        )
    rows.append(("points in the band", "all", held.inside))
    rows.append(("points in the band of a measurement", "all", held.inside_measured))
    rows += [
        ("share of the variance at the points", part, share)
        for part, share in held.shares.items()
    ]
    rows.append(("porosity", "mean of the packings", float(found.porosities.mean())))
    return rows


def cascades() -> Table:
    """Both cascades; packings are computed once."""
    columns = {"scatter of conduction": "g", "what": "", "of": "", "value": ".3f"}
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in ("cascade", "cascade_scatter"):
            found = cascade(HERE / f"data/{name}.toml", folder)
            scatter = found.cascade.settings.laws.scatter_conduction
            rows += [(scatter, *row) for row in cascaded(found)]
    return Table(columns, rows)


def compute() -> Tables:
    """Packings, shares of the effects, closure and its band, temperatures of the
    bed.
    """
    beds = [settle(friction) for friction in FRICTION]
    store(beds[1])
    found = fit(beds)
    found.write(CLOSURE, {"scene": "beaulieu_2020/study.py", "friction": str(FRICTION)})
    print(
        "porosities",
        [round(bed.porosity, 4) for bed in beds],
        "residuals",
        found.content["residuals"],
    )
    eps = [
        found.closure()(k_solid=K_SOLID, k_fluid=K_GAS, eps=value)
        for value in (0.41, 0.43)
    ]
    slope = float(np.log(eps[1] / eps[0]) / 0.02)
    spread = band(beds[1], slope, found.content["residuals"]["rms"])
    half = float(spread["half width"][-1])
    file = {"file": str(CLOSURE)}
    published = closures.conductivity_zehner_bauer_schluender(
        K_GAS, K_SOLID, POROSITY, T_MEAN, 2 * R, 0.3, contact=0.0013
    )
    compared = {
        "this packing": file,
        "this packing, lower end of the band": K_GAS * (middle() - half),
        "this packing, upper end of the band": K_GAS * (middle() + half),
        "Batchelor and O'Brien 1977, 4 ln(ratio) - 11": K_GAS
        * (4.0 * np.log(K_SOLID / K_GAS) - 11.0),
        "Zehner, Bauer, Schluender, steel": float(published),
        "what the points ask for": K_GAS * ASKED,
    }
    tables = {
        "effects": effects(beds[1]),
        "band": spread,
        "results": scored(compared),
        "curves": curves(half),
    }
    return tables | {"cascade": cascades()}


def plot(tables: Tables) -> dict[str, Any]:
    """Temperatures over time with the band, and k/k_gas effect by effect."""
    points, found, effect = reference(), tables["curves"], tables["effects"]
    figure, (left, right) = gallery.figure(1, 2, size=(11.5, 4.6))
    for x, colour in (
        (0.04, gallery.VERMILION),
        (0.06, gallery.BLUE),
        (0.073, gallery.GREEN),
    ):
        left.plot(
            found["t [s]"],
            found[f"{x:g} m [K]"] - 273.15,
            color=colour,
            label=f"{100 * x:g} cm below the plate",
        )
        ends = (found[f"{x:g} m, {name} [K]"] - 273.15 for name in ("low", "high"))
        left.fill_between(found["t [s]"], *ends, color=colour, alpha=0.2, lw=0)
        here = points.x == x
        left.plot(points.t[here], points.value[here] - 273.15, ".", color=colour, ms=4)
    left.set(
        xlabel="t [s]",
        ylabel=r"T [$^\circ$C]",
        title="points measured, lines predicted with their band",
    )
    left.legend(loc="upper left")
    names = effect.values("effect")
    right.barh(
        range(len(names)),
        effect["k/k_gas"],
        color=[gallery.GREY] * 2 + [gallery.BLUE] * (len(names) - 2),
    )
    right.axvline(ASKED, color=gallery.BLACK, ls="--")
    right.set_yticks(range(len(names)), names, fontsize=8)
    right.invert_yaxis()
    right.set(xlabel="$k/k_{gas}$ (dashed: what the points ask for)")
    return {"beaulieu": figure}
