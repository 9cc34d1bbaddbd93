"""Speed and accuracy of the discrete elements beside LIGGGHTS and LAMMPS: tables and a plot here, or in a folder.

python studies/dem_speed/study.py [FOLDER]
"""

import csv
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from contbed.dem import heat, heat_pair, network
from contbed.dem.contact import hertz_impact
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles, pair_table
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Domain, box

HERE = Path(__file__).parent
D, STEP, REPEATS = 2e-3, 1e-5, 3
STEPS = {2500: 12000, 16000: 3000}
BEDS = {2500: (13, 1000.0), 16000: (24, 2500.0)}  # width in diameters, density
PEERS = {"LIGGGHTS": ("liggghts", "liggghts.in"), "LAMMPS": ("lmp", "lammps.in")}
SKINS = (5e-4, 1e-4)  # of the shared decks, and the default of contbed


def cpu_of(command: list[str], folder: str) -> float:
    """User CPU time of a process [s]; what it prints goes to the file `printed`."""
    with open(Path(folder) / "printed", "w") as printed:
        process = subprocess.Popen(command, cwd=folder, stdout=printed, env={**os.environ, "OMP_NUM_THREADS": "1"})
        _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise RuntimeError(f"{' '.join(command)} ended with {status}")
    return usage.ru_utime


def write_data(path: Path, position: np.ndarray, width: float, density: float, held: np.ndarray | None = None) -> None:
    """A bed as both peers read it; particles that are held at a temperature are of type 2."""
    high = position[:, 2].max() + 2 * D
    kinds = np.ones(len(position), int) if held is None else np.where(held, 2, 1)
    rows = [
        f"{k} {kind} {D} {density} {x:.12g} {y:.12g} {z:.12g}"
        for k, (kind, (x, y, z)) in enumerate(zip(kinds, position.tolist(), strict=True), 1)
    ]
    sides = f"0 {width:.9g} xlo xhi\n0 {width:.9g} ylo yhi\n{-D:.9g} {high:.9g} zlo zhi"
    path.write_text(
        f"settled bed\n\n{len(rows)} atoms\n{kinds.max()} atom types\n\n{sides}\n\nAtoms\n\n" + "\n".join(rows) + "\n"
    )


def own_seconds(simulation: Simulation, steps: int) -> float:
    """CPU time of some steps [s], the best of several."""
    simulation.run(200)
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        simulation.run(steps)
        times.append(time.process_time() - start)
    return min(times)


def peer_seconds(program: str, deck: str, width: float, skin: float, steps: int, folder: str) -> float:
    """The same of a peer, start and reading taken off."""
    variables = {"data": "bed.data", "L": repr(width), "skin": repr(skin)}
    command = [program, "-in", str(HERE / deck), *(part for pair in variables.items() for part in ("-var", *pair))]
    times = {n: min(cpu_of([*command, "-var", "steps", str(n)], folder) for _ in range(REPEATS)) for n in (0, steps)}
    return times[steps] - times[0]


def speed() -> list[dict]:
    """Particle-steps per CPU second in the same settled bed, all codes with the same skins of their neighbour lists."""
    rows = []
    pack((6 * D, 6 * D), count=50)  # compiles
    for count, (width, density) in BEDS.items():
        side, material, steps = width * D, Material(density), STEPS[count]
        start = time.process_time()
        bed = pack((side, side), count=count, material=material)
        found = bed.statistics
        print(
            f"packing of {count}: {time.process_time() - start:.1f} CPU s, porosity {found['porosity_core']:.4f} core "
            f"{found['porosity_box']:.4f} box, coordination {found['coordination']:.3f}"
        )
        domain = Domain((0, 0, 0), (side, side, np.inf))
        spheres = Particles(bed.position, bed.radius)
        with tempfile.TemporaryDirectory() as folder:
            write_data(Path(folder) / "bed.data", bed.position, side, density)
            for skin in SKINS:
                simulation = Simulation(
                    spheres, [material], box(domain), domain, time_step=STEP, skin=skin, largest_overlap=0.1
                )
                seconds = {"contbed": own_seconds(simulation, steps)}
                for name, (program, deck) in PEERS.items():
                    if shutil.which(program):
                        seconds[name] = peer_seconds(program, deck, side, skin, steps, folder)
                for name, value in seconds.items():
                    row = {"code": name, "particles": count, "skin_mm": f"{1e3 * skin:g}"}
                    row["particle_steps_per_cpu_s"] = f"{count * steps / value:.3g}"
                    row["times_LIGGGHTS"] = f"{seconds['LIGGGHTS'] / value:.2f}" if "LIGGGHTS" in seconds else ""
                    rows.append(row)
                    print(row)
    return rows


def conduction() -> list[dict]:
    """Heat through the contacts of 2500 particles: LIGGGHTS in explicit steps, and the network, by the same formula.

    LIGGGHTS 3.8 takes G = 2 k sqrt(pi) a with the radius a of the circle in which the spheres intersect. The heat
    capacity is the smallest of a few at which its steps are stable.
    """
    width, density = BEDS[2500][0] * D, BEDS[2500][1]
    bed = pack((width, width), count=2500, material=Material(density))
    low, high, k, steps = 2e-3, 24.7e-3, 26.0, 20000
    z = bed.position[:, 2]
    hot, cold = z < low, z > high
    times = []
    for _ in range(5):
        start = time.process_time()
        pairs = heat.near_pairs(bed.position, D)
        circle = np.sqrt(np.maximum(0.25 * (D - pairs.distance) * (D + pairs.distance), 0.0))
        parts = {"contact": heat_pair.contact_conductance(np.sqrt(np.pi) * circle, k, k)}
        own = network.between_layers(bed.position, pairs, parts, hot, cold, width**2, 125.0, 25.0)
        times.append(time.process_time() - start)
    rows = [{"code": "contbed, network", "heat_W": f"{own.heat:.7g}", "difference": "", "cpu_s": f"{min(times):.3g}"}]
    rows[0] |= {"steps": "", "times_contbed": "1"}
    if shutil.which("liggghts"):
        command = ["liggghts", "-in", str(HERE / "liggghts_etc.in")]
        variables = {"data": "bed.data", "kp": k, "cp": 0.07, "zl": low, "zh": high}
        command += [str(part) for pair in variables.items() for part in ("-var", *pair)]
        with tempfile.TemporaryDirectory() as folder:
            write_data(Path(folder) / "bed.data", bed.position, width, density, hot | cold)
            first = min(cpu_of([*command, "-var", "steps", "0"], folder) for _ in range(REPEATS))
            cost = min(cpu_of([*command, "-var", "steps", str(steps)], folder) for _ in range(REPEATS)) - first
            printed = (Path(folder) / "printed").read_text()
        words = (line.split() for line in printed.splitlines())
        table = np.array([[float(w) for w in row] for row in words if len(row) == 4 and row[1] == "2500"])
        near = np.abs(np.abs(table[:, 2:]) / own.heat - 1.0).max(axis=1) < 1e-3
        for count in (int(table[near][0, 0]), steps):
            value = table[table[:, 0] == count][-1, 3]
            seconds = cost * count / steps
            row = {"code": "LIGGGHTS, explicit", "heat_W": f"{value:.7g}", "difference": f"{value / own.heat - 1:.1e}"}
            row |= {"cpu_s": f"{seconds:.3g}", "steps": str(count), "times_contbed": f"{seconds / min(times):.0f}"}
            rows.append(row)
    for row in rows:
        print(row)
    return rows


def accuracy() -> list[dict]:
    """Error of the largest overlap and of the speed after a head-on impact, e = 1 and 0.9."""
    rows, radius, speed = [], D / 2, 0.1
    for steps in (20, 40, 80, 160, 320, 640):
        row: dict[str, object] = {"steps_per_impact": steps}
        for restitution in (1.0, 0.9):
            material = Material(restitution=restitution)
            mass = 2.0 / 3.0 * np.pi * radius**3 * material.density
            duration, deepest = hertz_impact(mass, radius / 2, pair_table([material])["youngs_modulus"][0, 0], speed)
            worst_speed, worst_overlap = 0.0, 0.0
            for phase in np.linspace(0.0, 1.0, 8, endpoint=False):  # where in a step the spheres meet
                gap = (1.0 + phase) * speed * duration / steps
                spheres = Particles([[0, 0, 0], [2 * radius + gap, 0, 0]], radius, velocity=[[speed, 0, 0], [0, 0, 0]])
                pair = Simulation(spheres, [material], gravity=(0, 0, 0), time_step=duration / steps)
                overlap = 0.0
                for _ in range(round(1.3 * steps) + 4):
                    pair.run(1)
                    overlap = max(overlap, *pair.contacts().overlap, 0.0)
                after = float(np.diff(pair.velocity[:, 0])[0])
                worst_speed = max(worst_speed, abs(after / (restitution * speed) - 1.0))
                worst_overlap = max(worst_overlap, abs(overlap / deepest - 1.0))
            row[f"speed_error_e_{restitution:g}"] = f"{worst_speed:.2e}"
            if restitution == 1.0:
                row["overlap_error"] = f"{worst_overlap:.2e}"
        rows.append(row)
        print(row)
    return rows


def scaling() -> list[dict]:
    """A settled bed with periodic sides, repeated."""
    rows, width = [], 10 * D
    bed = pack((width, width), count=1000, periodic=(True, True))
    for times in (1, 2, 4, 7, 10):
        cells = np.stack(np.meshgrid(range(times), range(times), [0], indexing="ij"), axis=-1).reshape(-1, 1, 3)
        position = (cells * width + bed.position).reshape(-1, 3)
        domain = Domain((0, 0, 0), (times * width, times * width, np.inf), (True, True, False))
        simulation = Simulation(
            Particles(position, D / 2), [bed.material], box(domain), domain, time_step=STEP, largest_overlap=0.1
        )
        steps = max(100, 4_000_000 // len(position))
        value = own_seconds(simulation, steps) / steps
        rows.append(
            {
                "particles": len(position),
                "cpu_s_per_step": f"{value:.3g}",
                "particle_steps_per_cpu_s": f"{len(position) / value:.3g}",
            }
        )
        print(rows[-1])
    return rows


def write(path: Path, rows: list[dict]) -> None:
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def plot(path: Path, fast: list[dict], error: list[dict], size: list[dict]) -> None:
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 4), layout="constrained")
    groups = list(dict.fromkeys((row["particles"], row["skin_mm"]) for row in fast))
    for k, name in enumerate(dict.fromkeys(row["code"] for row in fast)):
        values = [float(row["particle_steps_per_cpu_s"]) / 1e6 for row in fast if row["code"] == name]
        left.bar(np.arange(len(values)) + 0.25 * (k - 1), values, 0.23, label=name)
    left.set_xticks(range(len(groups)), [f"{count}\n{skin} mm" for count, skin in groups])
    left.set_ylabel("million particle-steps per CPU second")
    left.set_title("settled bed, one core, by number and skin")
    left.legend()
    for key, label in (
        ("overlap_error", "largest overlap, e = 1"),
        ("speed_error_e_1", "speed after, e = 1"),
        ("speed_error_e_0.9", "speed after, e = 0.9"),
    ):
        middle.loglog([row["steps_per_impact"] for row in error], [float(row[key]) for row in error], "o-", label=label)
    middle.set_xticks([row["steps_per_impact"] for row in error], [str(row["steps_per_impact"]) for row in error])
    middle.minorticks_off()
    middle.set_xlabel("steps in an impact")
    middle.set_ylabel("relative error")
    middle.set_title("one impact against Hertz")
    middle.legend()
    right.loglog(
        [row["particles"] for row in size], [1e3 * float(row["cpu_s_per_step"]) for row in size], "o-", label="measured"
    )
    first = size[0]
    right.loglog(
        [row["particles"] for row in size],
        [1e3 * float(first["cpu_s_per_step"]) * row["particles"] / first["particles"] for row in size],
        "k--",
        label="proportional",
    )
    right.set_xlabel("particles")
    right.set_ylabel("CPU time of a step, ms")
    right.set_title("run time against number")
    right.legend()
    figure.savefig(path, dpi=120)


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    folder.mkdir(parents=True, exist_ok=True)
    fast, error, size = speed(), accuracy(), scaling()
    for name, rows in (("speed", fast), ("conduction", conduction()), ("accuracy", error), ("scaling", size)):
        write(folder / f"{name}.csv", rows)
    plot(folder / "dem_speed.png", fast, error, size)


if __name__ == "__main__":
    main()
