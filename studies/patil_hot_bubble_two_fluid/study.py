"""Hot gas injected into a bed at incipient fluidization: the two-fluid model beside particles (patil_hot_bubble).

python studies/patil_hot_bubble_two_fluid/study.py run FOLDER [CASE ...]   # half_3mm_900, ...; else all of CASES
python studies/patil_hot_bubble_two_fluid/study.py plot FOLDER             # results.csv, bubble.png, snapshots.png
python studies/patil_hot_bubble_two_fluid/study.py bubble RUN              # size and temperature over time of one run
"""

import csv
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import matplotlib.pyplot as plt
import meshio
import numpy as np
from scipy.ndimage import label

import contbed as cb

HERE = Path(__file__).parent
PARTICLES = HERE.parent / "patil_hot_bubble" / "bubble.csv"
CASES = ("half_2mm_300", "half_2mm_900", "half_3mm_300", "half_3mm_600", "half_3mm_900", "half_3mm_900_fine")
BACKGROUND = {1: 0.65, 2: 1.1, 3: 1.45}  # m/s by diameter in mm
FLUX, DENSITY, T_BED = 17.55, 1.177, 300.0  # kg/m2/s of the jet, kg/m3 at T_BED
OPEN = 0.8  # porosity above which a cell belongs to a bubble
STOP, LATE, END = 0.09, 0.15, 0.225  # s, of the half bed
EMULSION, DEPTH = 0.4, 0.14  # porosity at the start; depth of the bed [m]


def scene(case):
    """`half_3mm_900` with another diameter and temperature; `_fine` halves the cells."""
    size, T = case.removesuffix("_fine").removeprefix("half_").split("mm_")
    background, T = BACKGROUND[int(size)], float(T)
    changes = {
        "solid.diameter": 1e-3 * int(size),
        "boundary.bottom.velocity": background,
        "initial.u_gas": background,
        "boundary.jet.T_gas": T,
        "boundary.jet.velocity": FLUX / DENSITY * T / T_BED,
    }
    changes["initial.layer"] = [{"end": DEPTH, "eps_s": 1.0 - EMULSION, "u_gas": background / EMULSION}]
    if case.endswith("_fine"):
        changes["mesh.cells"] = [60, 160]
    return cb.load(HERE / "half_3mm_900.toml", changes)


def run(folder, cases):
    for case in cases:
        start = time.process_time()
        result = cb.run(scene(case), Path(folder) / case)
        closed = [f"{name} {balance['relative_residual']:.1e}" for name, balance in result.balances.items()]
        print(case, f"{time.process_time() - start:.0f} s of CPU,", result.qoi["steps"], "steps,", *closed, flush=True)


def field(mesh, name):
    """A field of a rectangle, by column and row, and the size of its cells."""
    block = mesh.cells[0].data
    centre = mesh.points[block].mean(axis=1)
    x, z = np.unique(centre[:, 0].round(9)), np.unique(centre[:, 1].round(9))
    order = np.lexsort((centre[:, 1].round(9), centre[:, 0].round(9)))
    return mesh.cell_data[name][0][order].reshape(len(x), len(z)), (x[1] - x[0], z[1] - z[0])


def bubble(mesh):
    """Diameter of a circle as large as the bubble [m], its mean gas temperature [K]: the largest connected region of
    porosity above OPEN that does not belong to the freeboard.
    """
    (eps_s, size), (T, _) = field(mesh, "eps_s"), field(mesh, "T_gas")
    parts, number = label(eps_s < 1.0 - OPEN)
    free = set(np.unique(parts[:, -1])) - {0}
    sizes = [0 if k in free else int((parts == k).sum()) for k in range(1, number + 1)]
    if not sizes or max(sizes) == 0:
        return 0.0, np.nan
    inside = parts == 1 + int(np.argmax(sizes))
    pores = 1.0 - eps_s[inside]
    return np.sqrt(4.0 * inside.sum() * size[0] * size[1] / np.pi), float(T[inside] @ pores / pores.sum())


def series(folder):
    """(t, diameter, T, hottest particles) of a run."""
    times = np.loadtxt(folder / "profiles.csv", delimiter=",", skiprows=1)
    with open(folder / "profiles.csv") as file:
        names = file.readline().strip().split(",")
    hottest = dict(zip(times[:, 0], times[:, names.index("T_solid_max [K]")], strict=True))
    rows = []
    for part in ElementTree.parse(folder / "fields.pvd").iter("DataSet"):
        t = float(part.get("timestep"))
        mesh = meshio.read(folder / part.get("file"))
        rows.append((t, *bubble(mesh), hottest[min(hottest, key=lambda at, t=t: abs(at - t))]))
    return np.array(rows)


def particles():
    """The same columns of the particle study by case."""
    found = {}
    with open(PARTICLES) as file:
        for row in csv.DictReader(file):
            names = ("t [s]", "diameter [m]", "T_bubble [K]", "T_particle_max [K]")
            found.setdefault(row["case"], []).append([float(row[name]) for name in names])
    return {name: np.array(rows) for name, rows in found.items()}


def curves(found, discrete):
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.3), layout="constrained")
    for name, rows in found.items():
        size, T, *fine = name.split("_")[1:]
        color = plt.get_cmap("inferno")((float(T) - 250.0) / 800.0)
        style, wide = {"2mm": "--", "3mm": "-"}[size], 0.9 if fine else 1.8
        dots = {"ls": "", "marker": "o+"[style == "--"], "ms": 4}
        for data, mark, how in (
            (rows, "two fluids", {"ls": style, "lw": wide}),
            (discrete.get(name), "particles", dots),
        ):
            if data is None:
                continue
            shown, text = data[:, 1] > 0.0, ", ".join((size, f"{T} K", mark, *fine))
            for panel, column, factor in ((axes[0], 1, 1e2), (axes[1], 2, 1.0)):
                panel.plot(data[shown, 0], factor * data[shown, column], color=color, label=text, **how)
    axes[0].set(xlabel="time, s", ylabel="diameter of the bubble, cm")
    axes[1].set(xlabel="time, s", ylabel="mean gas temperature in the bubble, K")
    axes[0].legend(fontsize=6, ncols=2)
    figure.savefig(HERE / "bubble.png", dpi=110)


def snapshots(folder):
    figure, panels = plt.subplots(1, 4, figsize=(10.4, 6.6), layout="constrained", sharey=True)
    for axes, t in zip(panels, (0.05, 0.09, 0.1, 0.15), strict=True):
        mesh = meshio.read(folder / f"fields_{round(t / 0.005) - 1:04d}.vtu")
        (eps_s, size), (T, _) = field(mesh, "eps_s"), field(mesh, "T_gas")
        extent = (0.0, 1e2 * size[0] * T.shape[0], 0.0, 1e2 * size[1] * T.shape[1])
        image = axes.imshow(T.T, origin="lower", extent=extent, cmap="inferno", vmin=T_BED)
        axes.contour(eps_s.T, [1.0 - OPEN], colors="0.8", linewidths=0.8, extent=extent)
        axes.set(title=f"{t:g} s", xlabel="cm")
        figure.colorbar(image, ax=axes, orientation="horizontal", label="gas, K")
    figure.savefig(HERE / "snapshots.png", dpi=100)


def plot(folder):
    found = {case: series(Path(folder) / case) for case in CASES if (Path(folder) / case / "profiles.csv").exists()}
    discrete = particles()
    curves(found, discrete)
    snapshots(Path(folder) / "half_3mm_900")
    with open(HERE / "results.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        moments = [f"{name} at {t} s" for t in (STOP, LATE) for name in ("diameter [m]", "T_bubble [K]")]
        writer.writerow(("case", "model", *moments, "largest diameter [m]", "T_particle_max [K]"))
        for name in found:
            for model, rows in (("two fluids", found[name]), ("particles", discrete.get(name))):
                if rows is not None:
                    at = [rows[np.argmin(np.abs(rows[:, 0] - t)), 1:3] for t in (STOP, LATE)]
                    values = (*at[0], *at[1], rows[:, 1].max(), rows[:, 3].max())
                    writer.writerow((name, model, *(f"{value:.4g}" for value in values)))


if __name__ == "__main__":
    if sys.argv[1] == "run":
        run(sys.argv[2], sys.argv[3:] or CASES)
    elif sys.argv[1] == "bubble":
        for row in series(Path(sys.argv[2])):
            print("{:.3f} s  {:.4f} m  {:.1f} K  particles up to {:.1f} K".format(*row))
    else:
        plot(sys.argv[2])
