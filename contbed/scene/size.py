"""How large a run would be, from its scene alone: cells, particles, grid of the gas,
rows and files.

A scene that needs more memory than there is, or counts beyond `LIMITS`, is refused
before anything is made, unless the user allows it. Bytes are what a run takes at least;
what an automatic mesh or a factorisation adds the plan knows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import prod
from pathlib import Path
from typing import Any

from contbed.scene.mesh import MeshFile
from contbed.scene.toml_lines import KeyPath, Origin

# what is counted: most without --allow-large, bytes of one at least (measured on runs
# of some 1e5)
LIMITS = {
    "cells of a line": (2_000_000, 2_000.0),
    "cells of a plane": (2_000_000, 3_000.0),
    "cells of a volume": (1_000_000, 15_000.0),
    "particles": (2_000_000, 3_000.0),
    "cells of the gas": (5_000_000, 1_000.0),
    "rows of profiles.csv": (1_000_000, 500.0),
    "files of fields": (10_000, 0.0),
    "time steps": (100_000_000, 0.0),
}
_CELLS = {1: "cells of a line", 2: "cells of a plane", 3: "cells of a volume"}
_SPLIT = {"triangle": 2, "tetrahedron": 6}  # simplices made of one cell
_SHARE = 0.9  # of the memory that is available
_ALLOW = "allowed by --allow-large, in Python load(..., allow_large=True)"


def too_large(
    parts: Mapping[str, Any], origin: Origin
) -> Iterator[tuple[KeyPath, str]]:
    """Keys that ask for more memory or cells than exist or than are accepted without
    --allow-large, and by how much.
    """
    if origin.allow_large:
        return
    available = available_bytes()
    for path, what, count in counts(parts):
        most, each = LIMITS[what]
        need = count * each
        size = f"{_number(count)} {what}" + (
            f" need at least {_bytes(need)}" if each else ""
        )
        if need > _SHARE * available:
            yield (
                path,
                f"{size}, {_bytes(available)} are available; make it smaller, or "
                f"{_ALLOW}",
            )
        elif count > most:
            yield path, f"{size}; more than {_number(most)} are {_ALLOW}"


def counts(parts: Mapping[str, Any]) -> Iterator[tuple[KeyPath, str, float]]:
    """Yield the key, the name in `LIMITS` and the number of each thing that the
    tables ask for.
    """
    mesh, time = parts.get("mesh"), parts.get("time")
    if (
        mesh is not None
        and not isinstance(mesh, MeshFile)
        and getattr(mesh, "cells", None) is not None
    ):
        cells = prod(mesh.cells) if isinstance(mesh.cells, tuple) else mesh.cells
        dimension = getattr(mesh, "dimension", 1)
        cells *= 2.0 ** (dimension * getattr(mesh, "refine", 0)) * _SPLIT.get(
            getattr(mesh, "shape", ""), 1
        )
        yield ("mesh", "cells"), _CELLS[dimension], float(cells)
    particles, solids = parts.get("particles"), parts.get("solids")
    if particles is not None and solids:
        yield from _of_particles(particles, next(iter(solids.values())))
    end = getattr(time, "end", None)
    for key, what in (
        ("sample", "rows of profiles.csv"),
        ("fields", "files of fields"),
        ("step", "time steps"),
    ):
        interval = getattr(time, key, None)
        if isinstance(end, float) and isinstance(interval, float) and interval > 0.0:
            yield ("time", key), what, end / interval


def _of_particles(particles: Any, solid: Any) -> Iterator[tuple[KeyPath, str, float]]:
    """Yield the number of particles, and of the cells of a gas around them."""
    count = getattr(particles, "count", None)
    if isinstance(count, int):
        yield ("particles", "count"), "particles", float(count)
    packing = getattr(particles, "packing", None)
    if packing is not None and solid.diameter:
        key = "height" if packing.count is None else "count"
        yield ("particles", "packing", key), "particles", float(packing.number(solid))
    cell = getattr(particles, "cell", None)
    if cell and solid.diameter:
        wide, high = (solid.diameter * factor for factor in cell)
        cells = prod(particles.width) / wide**2 * particles.height / high
        yield ("particles", "cell"), "cells of the gas", cells


def available_bytes() -> float:
    """Memory that can still be taken, of the computer and of the group that the
    process is in; inf if unknown.
    """
    found = [float("inf")]
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        found += [
            1024.0 * float(line.split()[1])
            for line in lines
            if line.startswith("MemAvailable:")
        ]
    except (OSError, ValueError, IndexError):
        pass
    try:
        group = Path("/sys/fs/cgroup")
        limit = (group / "memory.max").read_text(encoding="ascii").strip()
        if limit != "max":
            found.append(
                max(
                    float(limit)
                    - float((group / "memory.current").read_text(encoding="ascii")),
                    0.0,
                )
            )
    except (OSError, ValueError):
        pass
    return min(found)


def _number(count: float) -> str:
    return f"{count:,.0f}".replace(",", " ") if count < 1e15 else f"{count:.1e}"


def _bytes(count: float) -> str:
    power = 9 if count < 1e12 else 12
    return f"{count / 10**power:.3g} {'GB' if power == 9 else 'TB'}"
