"""Particles of other programs: text dumps of LIGGGHTS and LAMMPS (`dump custom`).

A dump needs x y z (or xu yu zu, unwrapped, or the scaled xs ys zs) and radius or
diameter; a temperature is taken from a column `temperature`, `Temp` or `f_Temp`, as the
programs' heat fixes write it. Files ending in .gz are unpacked.
"""

from __future__ import annotations

import gzip
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from contbed.errors import SceneError

Array = NDArray[np.float64]

_TEMPERATURES = ("temperature", "Temp", "f_Temp", "f_Temp[0]", "d_temp")
_OPTIONAL = ("ITEM: UNITS", "ITEM: TIME", "ITEM: LABEL")


@dataclass(frozen=True)
class Frame:
    """Particles at one time step, in the order of their ids if the dump has them.

    `low`, `high` are the corners of the box, `periodic` its closed axes, `T` None
    without a column of temperatures. Lengths are in the unit of the dump; the programs'
    SI is metres. `lines` holds the line of each particle in the file, `line_count` that
    of their number and `line_box` that of the first bounds.
    """

    step: int
    x: Array
    radius: Array
    T: Array | None
    low: Array
    high: Array
    periodic: tuple[bool, ...]
    columns: dict[str, Array]
    lines: NDArray[np.int64]
    line_count: int
    line_box: int

    def require_usable(self, path: Path | str) -> None:
        """Refuse a frame that gives no assembly.

        Raises
        ------
        SceneError : with file and line: no particles, an id twice, a box without
            volume, particles outside of it
        """
        at = f"step {self.step}"
        if not len(self.x):
            raise SceneError(f"{path}:{self.line_count}: {at} has no particles")
        for axis, name in enumerate("xyz"):
            if not self.low[axis] < self.high[axis]:
                raise SceneError(
                    f"{path}:{self.line_box + axis}: the box of {at} has no volume: "
                    f"{name} from {self.low[axis]:g} to "
                    f"{self.high[axis]:g}"
                )
        if "id" in self.columns:
            ids = self.columns["id"]
            if (twice := ids[1:] == ids[:-1]).any():
                k = int(twice.argmax()) + 1
                raise SceneError(
                    f"{path}:{self.lines[k]}: id {ids[k]:.0f} occurs twice in {at}"
                )
        # centres may leave a side that is not periodic by rounding, or until a
        # shrinking box is measured again
        beyond = (
            np.maximum(self.low - self.x, self.x - self.high) > self.radius[:, None]
        )
        beyond &= ~np.array(self.periodic)
        if beyond.any():
            k = int(beyond.any(axis=1).argmax())
            axis = int(beyond[k].argmax())
            raise SceneError(
                f"{path}:{self.lines[k]}: a particle of {at} is outside of the box: "
                f"{'xyz'[axis]} = "
                f"{self.x[k, axis]:g}, the box from {self.low[axis]:g} to "
                f"{self.high[axis]:g}"
            )


def read_dump(path: Path | str) -> list[Frame]:
    """Read all frames of a text dump.

    Raises
    ------
    SceneError : with file and line, where the dump is truncated, has no radius, or is
        no dump at all
    """
    lines = Lines(Path(path))
    frames = []
    while (line := lines.next_or_none()) is not None:
        if not line.strip() or _skip_optional(line, lines):
            continue
        frames.append(_frame(line, lines))
    if not frames:
        raise SceneError(f"{path}:1: no frame in this dump")
    if not lines.ended:
        raise lines.error(
            "truncated: the last line has no end; if it is complete, end it with a "
            "line break"
        )
    return frames


def is_dump(path: Path | str) -> bool:
    """Check whether a file starts as a dump does."""
    if Path(path).suffix.lower() == ".vtu":  # which may be binary
        return False
    line = Lines(Path(path)).next_or_none()
    return line is not None and line.startswith("ITEM:")


class Lines:
    """Lines of a file with their numbers."""

    def __init__(self, path: Path):
        self.path, self.number = path, 0
        try:
            with (
                gzip.open(path, "rt")
                if path.suffix == ".gz"
                else open(path, encoding="utf-8") as file
            ):
                text = file.read()
        except FileNotFoundError:
            raise SceneError(f"{path}:1: no such file") from None
        except (OSError, EOFError, UnicodeDecodeError) as error:
            raise SceneError(
                f"{path}:1: cannot be read: {getattr(error, 'strerror', None) or error}"
            ) from None

        self.lines, self.ended = text.splitlines(), text.endswith("\n")

    def next_or_none(self) -> str | None:
        """Return the next line; None after the last one."""
        if self.number >= len(self.lines):
            return None
        self.number += 1
        return self.lines[self.number - 1]

    def next(self, wanted: str) -> str:
        """Return the next line, where `wanted` should stand; SceneError after the
        last one.
        """
        line = self.next_or_none()
        if line is None:
            raise self.error(f"truncated: the file ends where {wanted} should follow")
        return line

    def error(self, text: str) -> SceneError:
        """Return an error at the present line."""
        return SceneError(f"{self.path}:{max(self.number, 1)}: {text}")

    def numbers(
        self, line: str, count: int, separator: str | None = None
    ) -> list[float]:
        """Return the `count` finite numbers of a line; SceneError if these are not
        what it holds.
        """
        words = line.split(separator)
        try:
            found = [float(word) for word in words]
        except ValueError:
            raise self.error(f"not {count} numbers: {line[:60]!r}") from None
        if len(found) != count or not np.isfinite(found).all():
            raise self.error(
                f"{len(found)} numbers where {count} finite ones are needed: "
                f"{line[:60]!r}"
            )
        return found


def _skip_optional(line: str, lines: Lines) -> bool:
    """Skip units and times, which LAMMPS may write before a step; return whether the
    line was one.
    """
    if not line.startswith(_OPTIONAL) or line.startswith("ITEM: TIMESTEP"):
        return False
    lines.next("its value")
    return True


def _frame(line: str, lines: Lines) -> Frame:
    if line.strip() != "ITEM: TIMESTEP":
        raise lines.error(
            "no text dump of LIGGGHTS or LAMMPS: expected 'ITEM: TIMESTEP'"
        )
    step = int(lines.numbers(lines.next("the step"), 1)[0])
    count, box, names, first, line_count, line_box = -1, None, None, 0, 0, 0
    while names is None:
        line = lines.next("an ITEM")
        if _skip_optional(line, lines):
            continue
        if line.startswith("ITEM: NUMBER OF ATOMS"):
            count = int(lines.numbers(lines.next("the number of particles"), 1)[0])
            line_count = lines.number
        elif line.startswith("ITEM: BOX BOUNDS"):
            line_box = lines.number + 1
            box = _box(line, lines)
        elif line.startswith("ITEM: ATOMS"):
            names = line.split()[2:]
            first = lines.number
        else:
            raise lines.error(f"unknown item: {line[:60]!r}")
    if count < 0 or box is None:
        raise lines.error(
            "the number of particles or the box bounds are missing before the particles"
        )
    have = min(count, len(lines.lines) - first)
    columns = dict(zip(names, _rows(lines, have, names), strict=True))
    if have < count:
        raise SceneError(
            f"{lines.path}:{len(lines.lines)}: truncated: step {step} has {have} of "
            f"{count} particles"
        )
    where = first + 1 + np.arange(have)
    order = (
        np.argsort(columns["id"], kind="stable") if "id" in columns else np.arange(have)
    )
    columns = {name: column[order] for name, column in columns.items()}
    x, radius = _positions(columns, box, lines), _radii(columns, lines)
    if not (np.isfinite(x).all() and np.isfinite(radius).all() and (radius > 0).all()):
        raise lines.error(
            f"step {step}: a position or radius is not a finite number, or a radius is "
            "not above 0"
        )
    T = next((columns[name] for name in _TEMPERATURES if name in columns), None)
    return Frame(step, x, radius, T, *box, columns, where[order], line_count, line_box)


def _rows(lines: Lines, have: int, names: list[str]) -> Array:
    """Read the columns of the next `have` lines; columns of text, such as an
    element, are nan.
    """
    rows: list[list[float]] = []
    for _ in range(have):
        words = lines.next("a particle").split()
        if len(words) != len(names):
            raise lines.error(
                f"truncated: {len(words)} values for the {len(names)} columns "
                f"{' '.join(names)}"
            )
        rows.append(list(_floats(words)))
    return np.array(rows).reshape(-1, len(names)).T.copy()


def _floats(words: list[str]) -> Iterator[float]:
    for word in words:
        try:
            yield float(word)
        except ValueError:
            yield float("nan")


def _box(line: str, lines: Lines) -> tuple[Array, Array, tuple[bool, ...]]:
    words = line.split()[3:]
    if "xy" in words:
        raise lines.error("a tilted box; contbed reads orthogonal ones")
    bounds = np.array(
        [lines.numbers(lines.next("the box bounds"), 2) for _ in range(3)]
    )
    # a dump of old programs names no boundaries
    kinds = words[-3:] if len(words) >= 3 else ["ff"] * 3
    return bounds[:, 0], bounds[:, 1], tuple(kind == "pp" for kind in kinds)


def _positions(
    columns: dict[str, Array], box: tuple[Array, Array, tuple[bool, ...]], lines: Lines
) -> Array:
    low, high, _ = box
    for names, scaled in (
        (("x", "y", "z"), False),
        (("xu", "yu", "zu"), False),
        (("xs", "ys", "zs"), True),
    ):
        if all(name in columns for name in names):
            x = np.stack([columns[name] for name in names], axis=1)
            return low + x * (high - low) if scaled else x
    raise lines.error(f"no positions: the columns are {' '.join(columns)}; dump x y z")


def _radii(columns: dict[str, Array], lines: Lines) -> Array:
    if "radius" in columns:
        return columns["radius"]
    if "diameter" in columns:
        return 0.5 * columns["diameter"]
    raise lines.error(
        f"no radius: the columns are {' '.join(columns)}; dump radius or diameter"
    )
