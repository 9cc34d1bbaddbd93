"""Which frequencies the particles' velocity in the core has: plane, duct, and duct of
coarser cells.

The duct's runs are those of duct.py and go on in results/vaishali_2007; the plane is
run here.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.many.validate import signal
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies._gallery.raw import resumed
from studies.vaishali_2007 import duct

HERE = Path(__file__).parent
RUNS = (duct.PLANE, "duct", "duct, cells twice as wide")
# s, length of the pieces whose spectra are averaged; the lowest frequency is its
# inverse
RECORD = 5.0
BANDS = {"slow": (0.0, 1.0), "clusters": (1.0, 5.0), "fast": (5.0, np.inf)}  # Hz
NOT_COMPARED = ("steps",)
# m, in the core of the plane
PROBES = {"low": [0.076, 4.7], "middle": [0.076, 5.1], "high": [0.076, 5.5]}
PROBED = {"time.sample": 0.01, "output.probes": PROBES}
SERIES = ("t [s]", "eps_s [1]", "u_solid [m/s]")
RESULTS = {
    "run": "", "recorded [s]": ".3g", "u_solid [m/s]": ".3g", "u_solid of particles "
                                                              "[m/s]": ".3g",
    "variance [m2/s2]": ".3g", "variance of particles [m2/s2]": ".3g",
    **{f"{name} [1]": ".2g" for name in BANDS}, "correlation over 0.4 m [1]": ".2g", "steps": "d",
}  # fmt: skip


def reference() -> dict[str, float]:
    """Variance along the riser [m2/s2] that CARPT's granular temperature leaves room
    for, if nothing else moved.
    """
    return {"variance of particles [m2/s2]": 3.0 * duct.MEASURED}


def series(run: str) -> tuple[list[dict[str, Any]], int]:
    """What the probes in the core saw while averages were taken, and the steps of
    the run.
    """
    if run == duct.PLANE:
        scene, folder = cb.load(HERE / "ff_wenyu.toml", PROBED), duct.KEPT / run
    else:
        scene, folder = duct.scene_of(run), duct.folder_of(run)
    result = resumed(scene, folder)
    rows = Table.read(folder / "profiles.csv")
    counted = rows["t [s]"] >= scene.time.average_from
    found = [
        {
            name: rows[name if name == "t [s]" else f"{probe} {name}"][counted]
            for name in SERIES
        }
        for probe in scene.output.probes
    ]
    return found, result.qoi["steps"]


def analysed(probes: Sequence[dict[str, Any]]) -> tuple[list[float], Any, Any]:
    """Means and variances of the axial velocity, in time and by particles; shares of
    the bands; the mean spectrum.
    """
    spectra, moments, resampled = [], [], []
    for probe in probes:
        s, u = probe["eps_s [1]"], probe["u_solid [m/s]"]
        favre = float(np.average(u, weights=s))
        moments.append(
            (u.mean(), favre, u.var(), float(np.average((u - favre) ** 2, weights=s)))
        )
        interval, values = signal.resampled(probe["t [s]"], u)
        resampled.append(values)
        spectra.append(signal.spectrum(interval, values, RECORD))
    frequency, power = spectra[0][0], np.mean([each[1] for each in spectra], axis=0)
    shares = [
        power[(frequency >= low) & (frequency < high)].sum() / power.sum()
        for low, high in BANDS.values()
    ]
    neighbours = [float(np.corrcoef(*pair)[0, 1]) for pair in pairwise(resampled)]
    return (
        [*np.mean(moments, axis=0), *shares, float(np.mean(neighbours))],
        frequency,
        power,
    )


def compute(cases: Sequence[str] = RUNS) -> Tables:
    """Spectra of the runs, and what they sum up to."""
    rows, lines = [], []
    for run in cases:
        probes, steps = series(run)
        values, frequency, power = analysed(probes)
        t = probes[0]["t [s]"]
        rows.append((run, t[-1] - t[0], *values, steps))
        print(*rows[-1], flush=True)
        lines += [(run, *pair) for pair in zip(frequency, power, strict=True)]
    tables = {
        "spectrum": Table(RESULTS, rows),
        "spectra": Table(
            {"run": "", "frequency [Hz]": ".4g", "power [m2/s]": ".4g"}, lines
        ),
    }
    if len(cases) == len(RUNS):
        return tables
    return gallery.updated(HERE, tables, dict.fromkeys(tables, ("run",)))


def plot(tables: Tables) -> dict[str, Any]:
    """Power of the axial velocity, and what it sums up to from high frequencies
    down.
    """
    figure, panels = gallery.figure(1, 2, size=(9.0, 3.8))
    for run in tables["spectrum"]["run"]:
        found = tables["spectra"].where({"run": run})
        frequency, power = found["frequency [Hz]"], found["power [m2/s]"]
        above = np.cumsum((power * frequency[0])[::-1])[::-1]
        panels[0].loglog(frequency, power, color=duct.COLOURS[run], label=run)
        panels[1].semilogx(frequency, above, color=duct.COLOURS[run])
    panels[0].set(
        xlabel="frequency [Hz]",
        ylabel=r"power of $u_\mathrm{solid}$ in the core [m$^2$/s]",
    )
    panels[1].set(
        xlabel="frequency [Hz]",
        ylabel=r"variance above the frequency [m$^2$/s$^2$]",
        ylim=(0, None),
    )
    (most,) = reference().values()
    panels[1].axhline(
        most, color=gallery.BLACK, linestyle=":", label=r"3 $\theta$ by CARPT"
    )
    panels[1].legend()
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3
    )
    return {"spectrum": figure}
