"""What a run in time has passed: its state, what it keeps, and how a checkpoint holds
it.
"""

from __future__ import annotations

import time as clock
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np

from contbed.errors import SceneError
from contbed.output import checkpoint
from contbed.scene.identity import identity
from contbed.scene.toml_lines import Origin

SAME = 1e-12  # relative distance below which two times are the same


@dataclass(frozen=True, kw_only=True)
class History:
    """State of a run and what it has passed; a step returns a new one.

    size : of the next step [s]; taken : of the last one
    kept : what the results need of the output times
    outlet : time and values of the outlet after each step
    resume : the history before the step that was cut short to meet the end, from which
        a run to a later end resumes; None where no step was
    """

    state: Any
    size: float
    time: float = 0.0
    taken: float = 0.0
    steps: int = 0
    kept: Mapping[float, Any] = field(default_factory=dict)
    outlet: tuple[tuple[float, ...], ...] = ()
    resume: Self | None = None
    # whether the start is an output time
    at_start: ClassVar[bool] = True
    # names of arrays whose lengths may change in a run
    free: ClassVar[Collection[str]] = ()

    @property
    def snapshot(self) -> Any:
        """What is kept of an output time."""
        return self.state

    def keeping(self, *times: float) -> Self:
        """Return the history that keeps its state as that of output times."""
        return replace(self, kept={**self.kept, **dict.fromkeys(times, self.snapshot)})

    def pack(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the arrays and numbers of a checkpoint."""
        if self.resume is not None:
            return self.resume.pack()
        arrays: dict[str, Any] = {}
        return arrays, packed(self, "", arrays)["fields"]

    def resumed(self, arrays: Mapping[str, Any], meta: Mapping[str, Any]) -> Self:
        """Return the history of a checkpoint of the run that begins with this one.

        Raises
        ------
        SceneError : the checkpoint does not fit
        """
        names = (item.name for item in fields(self) if item.name != "resume")
        return self.like({name: unpacked(meta[name], arrays) for name in names})

    def like(self, values: Mapping[str, Any]) -> Self:
        """Return a history of plain values, which have the form that this one has.

        Raises
        ------
        SceneError : they have another
        """
        found = self.of(values)
        own = {name: value for name, value in vars(self).items() if name != "kept"}
        checkpoint.require_form(vars(found), own, self.free)
        for kept in found.kept.values():
            pair = (
                dict(enumerate(_several(kept))),
                dict(enumerate(_several(self.snapshot))),
            )
            checkpoint.require_form(*pair, free=("0", "1"))
        return found

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Return a history from its plain values."""
        return cls(**values)

    def fitted(self, time: Any, where: Origin) -> Self:
        """Return the history as if the run had been asked for this end and these output
        times from its start.

        Raises
        ------
        SceneError : an output time has passed and was not kept, or the end has passed
        """
        reached = self.time * (1 + SAME)
        if time.end < self.time * (1 - SAME):
            text = f"lies before {self.time:g} s, which the checkpoint has reached"
            key = where.at(("time", "end"))
            raise SceneError(f"{key}: time.end = {time.end:g}: {text}")
        passed = [
            t for t in output_times(time) if t <= reached and (t > 0.0 or self.at_start)
        ]
        for t in passed:
            if t not in self.kept and abs(t - self.time) > SAME * t:
                text = (
                    f"{t:g} s lies before {self.time:g} s, which the checkpoint has "
                    "reached, and was not kept"
                )
                key = where.at(("time", "times"))
                raise SceneError(f"{key}: time.times: {text}")
        kept = {t: self.kept.get(t, self.snapshot) for t in passed}
        return replace(self, kept=kept)


def output_times(time: Any) -> Sequence[float]:
    """Return the times at which profiles are kept, the end included [s]."""
    return sorted({*time.times, time.end})


def _several(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


def packed(value: Any, name: str, arrays: dict[str, Any]) -> Any:
    """Return a value as JSON has it; arrays are put aside under names that begin with
    `name`. A step that was cut short is left out.
    """
    if is_dataclass(value) and not isinstance(value, type):
        names = [item.name for item in fields(value) if item.name != "resume"]
        found = {
            each: packed(getattr(value, each), f"{name}.{each}".strip("."), arrays)
            for each in names
        }
        return {"fields": found}
    if isinstance(value, Mapping):
        items = enumerate(value.items())
        pairs = [[key, packed(item, f"{name}_{k}", arrays)] for k, (key, item) in items]
        return {"pairs": pairs}
    if isinstance(value, tuple) and not (value and isinstance(value[0], tuple)):
        items = enumerate(value)
        return [packed(item, f"{name}_{k}", arrays) for k, item in items]
    if isinstance(value, tuple | np.ndarray):
        arrays[name] = np.asarray(value)
        return {"rows" if isinstance(value, tuple) else "array": name}
    return value


def unpacked(value: Any, arrays: Mapping[str, Any]) -> Any:
    """Return the value that `packed` has written."""
    if isinstance(value, list):
        return tuple(unpacked(item, arrays) for item in value)
    if not isinstance(value, dict):
        return value
    if "fields" in value:
        return {name: unpacked(item, arrays) for name, item in value["fields"].items()}
    if "pairs" in value:
        pairs = ((key, unpacked(item, arrays)) for key, item in value["pairs"])
        return {tuple(key) if isinstance(key, list) else key: v for key, v in pairs}
    if "rows" in value:
        return tuple(tuple(row) for row in arrays[value["rows"]].tolist())
    return arrays[value["array"]]


class Saver:
    """Writes checkpoints of a run at intervals of wall time, and the last one when the
    block ends, however it ends.

    Parameters
    ----------
    folder : takes the checkpoint; None: nothing is written
    scene : whose run it is
    """

    def __init__(self, folder: Path | None, scene: Any):
        self.folder, self.every = folder, scene.time.checkpoint_every
        self.label = {} if folder is None else identity(scene)
        self.last: Any = None
        self.written = clock.monotonic()

    def offer(self, history: Any) -> None:
        """Write a history if it is time, else remember it."""
        self.last = history
        if clock.monotonic() - self.written >= self.every:
            self._write()

    def _write(self) -> None:
        if self.folder is not None and self.last is not None:
            arrays, meta = self.last.pack()
            checkpoint.save(self.folder, arrays, meta | {"identity": self.label})
        self.last, self.written = None, clock.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._write()
