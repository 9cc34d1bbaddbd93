"""What a bed of particles does as a whole, and no closure states: u_mf, settling,
bubbles, jets, silos.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

import contbed as cb
from contbed import closures
from contbed.two_fluid.plan import plan
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
Array = NDArray[np.float64]
NOT_COMPARED = ("CPU [s]",)
GRAVITY = 9.81  # m/s2
COLUMNS = dict.fromkeys(("check", "case", "quantity"), "") | {
    "computed": ".4g", "reference": ".4g", "ratio": ".3g", "reference is": "", "CPU [s]": ".2g",
}  # fmt: skip
Row = tuple[str, str, str, float, float, float, str, float]

# share of the weight in the pressure drop from which a bed counts as fluidized
CARRIED = 0.95
# over that at which the drag law carries the bed
SPEEDS = np.array([0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1])
SETTLED = 0.8  # s, after which the pressure drop is averaged
# fraction from which particles rub: default, and a loose random packing
FRICTION_STARTS = (0.5, 0.57)
# that settle; the bed of the densest is still falling at the end
FRACTIONS = (0.01, 0.05, 0.1, 0.2)
# diameter of the bubble at the start and height of its centre [m]
VOID, CENTRE = 0.05, 0.1
# solids fraction below which a cell belongs to a bubble or a jet, half of that of the
# bed
OPEN = 0.3
ANGLE = 0.49742  # rad, of internal friction, the default of a scene
# of the silo: coefficient, distance of its walls [m]
WALL_FRICTION, SLOT_WIDTH = 0.3, 0.05
DEPTHS = (0.05, 0.1, 0.15)  # of the bed in the silo [m]
NOZZLE = 0.01  # m, width of the slot of the jet
JETS = (3.0, 4.5, 6.0)  # m/s
LATE = 0.4  # s, from when on a jet is averaged


def carried_at(share: Callable[[float], float], velocities: Iterable[float]) -> float:
    """Find the velocity [m/s] at which `share`, that of the weight in the pressure
    drop, reaches CARRIED.
    """
    found = np.array([(u, share(u)) for u in velocities])
    first = max(1, int(np.argmax(found[:, 1] >= CARRIED)))
    return float(
        np.interp(
            CARRIED, found[first - 1 : first + 1, 1], found[first - 1 : first + 1, 0]
        )
    )


def carrying_velocity(drag: str, eps: float, scene: cb.Scene) -> float:
    """Find the superficial velocity [m/s] at which a drag law carries a uniform bed
    of porosity eps.
    """
    gas, solid, law = scene.gas, scene.solid, closures.get(f"drag_{drag}", "drag")
    d, mu = solid.diameter, gas.viscosity

    def missing(u: float) -> float:
        beta = law(gas.density * u * d / mu, eps, d, mu)
        return float(
            beta * u / eps - eps * (1 - eps) * (solid.density - gas.density) * GRAVITY
        )

    return float(brentq(missing, 1e-4, 10.0))


def minimum() -> list[Row]:
    """Fluidization of 2 mm glass by two fluids, for two drag laws and onsets of
    friction, and by particles.
    """
    rows: list[Row] = []
    for start in FRICTION_STARTS:
        for drag in ("gidaspow", "di_felice"):
            base = cb.load(HERE / "minimum.toml")
            exact = carrying_velocity(drag, 1.0 - start, base)

            def share(u: float, drag: str = drag, start: float = start) -> float:
                changes = {
                    "closures.drag": f"drag_{drag}",
                    "solids.beads.friction.start": start,
                    "boundary.left.gas.velocity": u,
                    "initial.gas.velocity": u,
                }
                return carried_share(cb.load(HERE / "minimum.toml", changes))

            timed = gallery.cpu(
                lambda share=share, exact=exact: carried_at(share, exact * SPEEDS),
                samples=1,
            )
            case = f"two fluids, {drag}, friction from {start}"
            known = f"{drag} at a porosity of {1 - start:.2f}"
            rows.append(
                (
                    "fluidization",
                    case,
                    "u_mf [m/s]",
                    timed.result,
                    exact,
                    timed.result / exact,
                    known,
                    timed.seconds,
                )
            )
    base = cb.load(HERE / "minimum.toml")
    gas, solid = base.gas, base.solid
    d = solid.diameter
    Ar = gas.density * (solid.density - gas.density) * GRAVITY * d**3 / gas.viscosity**2
    wen_yu = (
        float(closures.minimum_fluidization_wen_yu(Ar))
        * gas.viscosity
        / (gas.density * d)
    )
    timed = gallery.cpu(
        lambda: carried_at(_particles, (0.9, 1.05, 1.2, 1.35)), samples=1
    )
    rows.append(
        (
            "fluidization",
            "particles, gidaspow",
            "u_mf [m/s]",
            timed.result,
            wen_yu,
            timed.result / wen_yu,
            "Wen and Yu",
            timed.seconds,
        )
    )
    return rows


def carried_share(scene: cb.Scene) -> float:
    """Find the share of the weight of the particles that the gas carries."""
    result = cb.run(scene)
    late = result.profiles["t [s]"] > SETTLED
    return float(
        result.profiles["pressure_drop [Pa]"][late].mean()
        / result.qoi["weight_of_solids"]
    )


def _particles(velocity: float) -> float:
    result = cb.run(
        cb.load(HERE / "particles.toml", {"boundary.bottom.gas.velocity": velocity})
    )
    return float(result.qoi["pressure_drop [Pa]"] / result.qoi["bed_weight [Pa]"])


def settling() -> list[Row]:
    """Exponent of hindered settling, v = v_t (1 - eps_s)^n, from the upper fronts of
    several fractions.
    """
    rows: list[Row] = []
    for drag in ("wen_yu", "di_felice"):

        def fronts(drag: str = drag) -> list[float]:
            found = []
            for s in FRACTIONS:
                scene = cb.load(
                    HERE / "settling.toml",
                    {
                        "closures.drag": f"drag_{drag}",
                        "initial.solids.beads.volume_fraction": s,
                    },
                )
                front = cb.run(scene).qoi["front_position_m"]
                found.append((scene.mesh.length - front) / scene.time.end)
            return found

        timed = gallery.cpu(fronts, samples=1)
        n, logarithm = np.polyfit(
            np.log(1.0 - np.array(FRACTIONS)), np.log(timed.result), 1
        )
        scene = cb.load(HERE / "settling.toml")
        Re = (
            scene.gas.density
            * np.exp(logarithm)
            * scene.solid.diameter
            / scene.gas.viscosity
        )
        known = richardson_zaki(float(Re))
        rows.append(
            (
                "settling",
                f"two fluids, {drag}, Re_t {Re:.2f}",
                "exponent n",
                n,
                known,
                n / known,
                "Richardson and Zaki",
                timed.seconds,
            )
        )
    return rows


def richardson_zaki(Re: float) -> float:
    """Exponent of Richardson and Zaki (1954, Trans. Inst. Chem. Eng. 32, 35) at the
    Reynolds number of one sphere.
    """
    if Re < 0.2:
        return 4.65
    if Re < 1.0:
        return 4.35 * Re**-0.03
    return 4.45 * Re**-0.1 if Re < 500.0 else 2.39


def _uniform_flow(scene: cb.Scene) -> float:
    return carrying_velocity("gidaspow", 0.42, scene)


def bubble() -> list[Row]:
    """Rise of a void that is round at the start, in half of a plane bed with the gas
    of minimum fluidization.
    """
    timed = gallery.cpu(rise, samples=1)
    t, centre, diameter = timed.result
    inside = (t >= 0.05) & (t <= 0.2)
    velocity = float(np.polyfit(t[inside], centre[inside], 1)[0])
    d = float(diameter[inside].mean())
    exact = 0.5 * np.sqrt(GRAVITY * d / 2.0)
    case, known = "two fluids, plane", "Davies and Taylor, plane"
    return [
        (
            "bubble",
            case,
            "velocity of rise [m/s]",
            velocity,
            exact,
            velocity / exact,
            known,
            timed.seconds,
        ),
        (
            "bubble",
            case,
            "diameter over that at the start",
            d / VOID,
            1.0,
            d / VOID,
            "kept",
            0.0,
        ),
    ]


def rise() -> tuple[Array, Array, Array]:
    """Times [s], height [m] of the middle of the void and diameter [m] of a circle
    as large.
    """
    scene = cb.load(HERE / "bubble.toml")
    u = _uniform_flow(scene)
    scene = cb.load(
        HERE / "bubble.toml",
        {"boundary.bottom.gas.velocity": u, "solids.beads.friction.start": 0.57},
    )
    bed, _ = plan(scene).bed()
    x, volume = bed.model.grid.centres, bed.model.grid.geometry.volume
    dense = x[:, 1] < scene.initial.layer[0].end
    s = np.where(dense & (np.hypot(x[:, 0], x[:, 1] - CENTRE) > 0.5 * VOID), 0.58, 0.0)
    bed.start(eps_s=s, u_gas=np.stack((0.0 * s, u / (1.0 - s)), axis=1), theta=1e-6)
    rows = []
    for end in (
        np.arange(1, round(scene.time.end / scene.time.sample) + 1) * scene.time.sample
    ):
        bed.advance(end)
        share = np.clip((OPEN + 0.1 - bed.state.eps_s) / 0.2, 0.0, 1.0) * volume
        void = np.where(x[:, 1] < 0.85 * scene.initial.layer[0].end, share, 0.0)
        rows.append(
            (end, void @ x[:, 1] / void.sum(), np.sqrt(8.0 * void.sum() / np.pi))
        )
    t, centre, diameter = np.array(rows).T
    return t, centre, diameter


def jet() -> list[Row]:
    """Height to which a plane jet keeps the particles away from its axis on average."""
    rows: list[Row] = []
    for speed in JETS:
        timed = gallery.cpu(lambda speed=speed: penetration(speed), samples=1)
        scene = cb.load(HERE / "bubble.toml")
        ratio = scene.gas.density / (scene.solid.density - scene.gas.density)
        known = 6.5 * NOZZLE * np.sqrt(ratio * speed**2 / (GRAVITY * NOZZLE))
        rows.append(
            (
                "jet",
                f"two fluids, plane, {speed:g} m/s",
                "depth [m]",
                timed.result,
                known,
                timed.result / known,
                "Yang and Keairns, round",
                timed.seconds,
            )
        )
    return rows


def penetration(speed: float) -> float:
    """Height [m] at which the mean fraction on the axis of a jet of `speed` [m/s]
    comes to OPEN.
    """
    scene = cb.load(HERE / "bubble.toml")
    inlet = {
        "type": "inlet",
        "on": "bottom",
        "start": 0.0,
        "end": 0.5 * NOZZLE,
        "gas": {"velocity": speed},
    }
    u = _uniform_flow(scene)
    scene = cb.load(
        HERE / "bubble.toml",
        {
            "boundary.jet": inlet,
            "boundary.bottom.gas.velocity": u,
            "solids.beads.friction.start": 0.57,
            "time.end": 1.2,
            "time.average_from": LATE,
            "output.levels": [0.005 + 0.01 * k for k in range(25)],
        },
    )
    levels = cb.run(scene).tables["levels"]
    axis = levels["x [m]"] <= levels["x [m]"].min() * 1.01
    height, s = levels["height [m]"][axis], levels["eps_s [1]"][axis]
    above = int(np.argmax(s > OPEN))
    return (
        float(np.interp(OPEN, s[above - 1 : above + 1], height[above - 1 : above + 1]))
        if above
        else 0.0
    )


def janssen() -> list[Row]:
    """Share of the weight that walls carry which are drawn up, against Janssen with
    the pressure alike on all sides.
    """
    rows: list[Row] = []
    for depth in DEPTHS:
        scene = cb.load(
            HERE / "janssen.toml",
            {
                "initial.layer": [
                    {"end": depth, "solids": {"beads": {"volume_fraction": 0.58}}}
                ]
            },
        )
        timed = gallery.cpu(
            lambda scene=scene: cb.run(scene).qoi["weight_walls"], samples=1
        )
        for K, what in (
            (1.0, "Janssen, K = 1"),
            (1.0 - np.sin(ANGLE), "Janssen, K = 1 - sin(angle)"),
        ):
            known = wall_share(depth, K)
            rows.append(
                (
                    "silo",
                    f"two fluids, depth {depth:g} m",
                    "share on the walls",
                    timed.result,
                    known,
                    timed.result / known,
                    what,
                    timed.seconds,
                )
            )
    return rows


def wall_share(depth: float, K: float, friction: float = WALL_FRICTION) -> float:
    """Share of the weight on two plane walls by Janssen (1895), K the horizontal
    over the vertical stress.
    """
    y = 2.0 * friction * K * depth / SLOT_WIDTH
    return float(1.0 - (1.0 - np.exp(-y)) / y)


CASES: dict[str, Callable[[], list[Row]]] = {
    "minimum": minimum,
    "settling": settling,
    "bubble": bubble,
    "jet": jet,
    "janssen": janssen,
}


def reference() -> Table:
    """The committed rows: what is known stands beside what was computed."""
    return Table.read(HERE / "results.csv")


def compute(cases: Sequence[str] = tuple(CASES)) -> Tables:
    """Rows of the chosen checks."""
    rows = []
    for name in cases:
        for row in CASES[name]():
            print(*row[:3], f"{row[3]:.4g}, {row[6]} {row[4]:.4g}", flush=True)
            rows.append(row)
    return {"results": Table(COLUMNS, rows)}


def plot(tables: Tables) -> dict[str, Any]:
    """Ratio of each computed number to its reference."""
    table = tables["results"]
    figure, axes = gallery.figure(1, 1, size=(9.0, 0.32 * len(table) + 1.2))
    names = [
        f"{row['case']}: {row['quantity']} / {row['reference is']}" for row in table
    ]
    colours = dict(zip(dict.fromkeys(table["check"]), gallery.PALETTE, strict=False))
    axes.barh(
        range(len(table)),
        table["ratio"],
        color=[colours[check] for check in table["check"]],
        height=0.6,
    )
    axes.axvline(1.0, color=gallery.BLACK, lw=0.8)
    axes.set(
        yticks=range(len(table)), yticklabels=names, xlabel="computed over reference"
    )
    axes.invert_yaxis()
    return {"ratios": figure}
