"""Hot gas injected into a bed at incipient fluidization: the two-fluid model beside
particles (patil_hot_bubble).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import meshio
import numpy as np

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies._gallery.bubbles import draw_bubbles, equivalent_diameter, largest_bubble
from studies._gallery.raw import raw

HERE = Path(__file__).parent
PARTICLES = HERE.parent / "patil_hot_bubble" / "bubble.csv"
# beds of the paper's width
WHOLE = ("1mm_900", "2mm_300", "2mm_900", "3mm_300", "3mm_600", "3mm_900")
HALF = (
    "half_1mm_900",
    "half_2mm_300",
    "half_2mm_900",
    "half_3mm_300",
    "half_3mm_600",
    "half_3mm_900",
)
# of a half bed, in place of 30 x 80; twice as many of a whole one
CELLS = {"fine": (60, 160), "finer": (120, 320)}
FINER = (
    *(f"{case}_fine" for case in (*HALF, *WHOLE[:3]) if case.endswith("900")),
    "half_1mm_900_finer",
)
CASES = (*HALF, *FINER, *WHOLE)
BACKGROUND = {1: 0.65, 2: 1.1, 3: 1.45}  # m/s by diameter in mm
FLUX, DENSITY, T_BED = 17.55, 1.177, 300.0  # kg/m2/s of the jet, kg/m3 at T_BED
OPEN = 0.8  # porosity above which a cell belongs to a bubble
# s, of the paper's bed: end of injection, later, end; the half bed has half of them
STOP, LATE, END = 0.18, 0.3, 0.45
# case and times [s] of snapshots.png
PICTURED, MOMENTS = "half_3mm_900", (0.05, 0.09, 0.1, 0.15)
COLUMNS = ("t [s]", "diameter [m]", "T_bubble [K]", "T_particle_max [K]")
EMULSION, DEPTH = 0.4, 0.28  # porosity at the start; depth of the paper's bed [m]
EVERY = 0.01  # s, between fields of the paper's bed


def scene(case: str, others: Mapping[str, Any] | None = None) -> cb.Scene:
    """The half bed, or the paper's, with another diameter and temperature; `_fine`
    and `_finer` have smaller cells.
    """
    size, given, *cells = case.removeprefix("half_").split("_")
    d, T = int(size.removesuffix("mm")), float(given)
    background = BACKGROUND[d]
    changes = {
        "solids.beads.diameter": 1e-3 * d,
        "boundary.bottom.gas.velocity": background,
        "initial.gas.velocity": background,
        "boundary.jet.gas.temperature": T,
        "boundary.jet.gas.velocity": FLUX / DENSITY * T / T_BED,
    }
    layer = {
        "end": scale(case) * DEPTH,
        "solids": {"beads": {"volume_fraction": 1.0 - EMULSION}},
        "gas": {"velocity": background / EMULSION},
    }
    changes["initial.layer"] = [layer]
    if is_whole(case):
        changes |= {"time.end": END, "time.sample": EVERY, "time.fields": EVERY}
    for name in cells:
        changes["mesh.cells"] = [
            round(2.0 * scale(case) * count) for count in CELLS[name]
        ]
    return cb.load(
        HERE / ("2mm_700.toml" if is_whole(case) else "half_3mm_900.toml"),
        changes | dict(others or {}),
    )


def is_whole(case: str) -> bool:
    """Whether a bed has the paper's width."""
    return not case.startswith("half_")


def scale(case: str) -> float:
    """Lengths and times of a bed over those of the paper's."""
    return 1.0 if is_whole(case) else 0.5


def run(case: str) -> None:
    """Run a case; its fields are kept as raw ones."""
    seconds, result = gallery.cpu(
        lambda: cb.run(scene(case), raw(HERE.name) / case), samples=1
    )
    closed = [
        f"{name} {balance['relative_residual']:.1e}"
        for name, balance in result.balances.items()
    ]
    print(
        case,
        f"{seconds:.0f} s of CPU,",
        result.qoi["steps"],
        "steps,",
        *closed,
        flush=True,
    )


def field(mesh: Any, name: str) -> tuple[Any, tuple[float, float]]:
    """A field of a rectangle, by column and row, and the size of its cells."""
    block = mesh.cells[0].data
    centre = mesh.points[block].mean(axis=1)
    x, z = np.unique(centre[:, 0].round(9)), np.unique(centre[:, 1].round(9))
    order = np.lexsort((centre[:, 1].round(9), centre[:, 0].round(9)))
    return mesh.cell_data[name][0][order].reshape(len(x), len(z)), (
        x[1] - x[0],
        z[1] - z[0],
    )


def bubble(mesh: Any) -> tuple[float, float]:
    """Diameter of a circle as large as the bubble [m], its mean gas temperature [K]."""
    (eps_s, size), (T, _) = field(mesh, "eps_s"), field(mesh, "T_gas")
    inside = largest_bubble(1.0 - eps_s, OPEN)
    if inside is None:
        return 0.0, np.nan
    pores = 1.0 - eps_s[inside]
    return equivalent_diameter(inside, size[0] * size[1]), float(
        T[inside] @ pores / pores.sum()
    )


def series(case: str) -> list[tuple[float, ...]]:
    """(t, diameter, T, hottest particles) of a run."""
    folder = raw(HERE.name) / case
    profiles = Table.read(folder / "profiles.csv")
    hottest = dict(
        zip(profiles[profiles.columns[0]], profiles["T_solid_max [K]"], strict=True)
    )
    rows = []
    for part in ElementTree.parse(folder / "fields.pvd").iter("DataSet"):
        t = float(str(part.get("timestep")))
        mesh = meshio.read(folder / str(part.get("file")))
        rows.append(
            (t, *bubble(mesh), hottest[min(hottest, key=lambda at, t=t: abs(at - t))])
        )
    return rows


def reference() -> Table:
    """The same of the particle study, by case."""
    return Table.read(PARTICLES)


def compute(cases: Sequence[str] = CASES) -> Tables:
    """Bubble over time of each case, and both models at two moments; the committed
    rows of other cases are kept.
    """
    for case in cases:
        run(case)
    found = Table(
        {"case": "", **dict.fromkeys(COLUMNS, ".6g")},
        [(case, *row) for case in cases for row in series(case)],
    )
    rows = []
    for case in cases:
        for model, table in (("two fluids", found), ("particles", reference())):
            if len(mine := table.where({"case": case})):
                rows.append((case, model, *moments(case, mine)))
    head = [
        f"{name} {when}"
        for when in ("at the end of injection", "later")
        for name in ("diameter [m]", "T [K]")
    ]
    columns = dict.fromkeys(
        (*head, "largest diameter [m]", "T_particle_max [K]"), ".4g"
    )
    new = {
        "results": Table({"case": "", "model": "", **columns}, rows),
        "bubble": found,
    }
    return gallery.updated(HERE, new, dict.fromkeys(new, ("case",)))


def moments(case: str, table: Table) -> tuple[float, ...]:
    """Diameter and temperature at STOP and LATE, the largest diameter, the hottest
    particle.
    """
    t, diameter, T, hottest = (table[name] for name in COLUMNS)
    stop, late = (
        int(np.argmin(np.abs(t - scale(case) * moment))) for moment in (STOP, LATE)
    )
    return (
        diameter[stop],
        T[stop],
        diameter[late],
        T[late],
        diameter.max(),
        hottest.max(),
    )


def plot(tables: Tables) -> dict[str, Any]:
    """Diameter and temperature of the bubble by both models; the gas at some times
    where the fields are.
    """
    figures = {}
    if "bubble" in tables:
        whole = [name for name in tables["bubble"].values("case") if is_whole(name)]
        half = [name for name in tables["bubble"].values("case") if not is_whole(name)]
        figures |= {
            name: plot_bubbles(tables["bubble"], reference(), cases)
            for name, cases in (("bubble", half), ("bubble_whole", whole))
        }
    if (raw(HERE.name) / PICTURED).exists():
        figures["snapshots"] = plot_gas(raw(HERE.name) / PICTURED)
    return figures


def plot_bubbles(found: Table, discrete: Table, cases: Sequence[str]) -> Any:
    """Lines are two fluids, marks particles."""
    figure, axes = gallery.figure(1, 2, size=(11, 4.3))
    curves = []
    for name in cases:
        size, T, *fine = name.removeprefix("half_").split("_")
        colour = gallery.shades(1, "inferno", (float(T) - 250.0) / 800.0)[0]
        line = {
            "ls": {"1mm": ":", "2mm": "--", "3mm": "-"}[size],
            "lw": 0.9 if fine else 1.8,
            "alpha": 0.5 if fine == ["finer"] else 1.0,
        }
        marks = {
            "ls": "",
            "marker": {"1mm": "x", "2mm": "+", "3mm": "o"}[size],
            "ms": 4,
        }
        for table, model, how in (
            (found, "two fluids", line),
            (discrete, "particles", marks),
        ):
            if len(mine := table.where({"case": name})):
                text = ", ".join((size, f"{T} K", model, *fine))
                curves.append(
                    (
                        *(mine[column] for column in COLUMNS[:3]),
                        {"color": colour, "label": text, **how},
                    )
                )
    draw_bubbles(axes, curves)
    axes[0].legend(fontsize=6, ncols=2)
    return figure


def plot_gas(folder: Path) -> Any:
    """Temperature of the gas with the outline of the bubble at some times."""
    figure, panels = gallery.figure(1, len(MOMENTS), size=(10.4, 6.6), sharey=True)
    for axes, t in zip(panels, MOMENTS, strict=True):
        mesh = meshio.read(folder / f"fields_{round(t / 0.005) - 1:04d}.vtu")
        (eps_s, size), (T, _) = field(mesh, "eps_s"), field(mesh, "T_gas")
        extent = (0.0, 1e2 * size[0] * T.shape[0], 0.0, 1e2 * size[1] * T.shape[1])
        image = axes.imshow(
            T.T, origin="lower", extent=extent, cmap="inferno", vmin=T_BED
        )
        axes.contour(eps_s.T, [1.0 - OPEN], colors="0.8", linewidths=0.8, extent=extent)
        axes.set(title=f"{t:g} s", xlabel="x [cm]")
        figure.colorbar(image, ax=axes, orientation="horizontal", label="gas [K]")
    return figure
