"""Compile all kernels once, at install time, so that no run has to wait for it:
`contbed warm`.

Small scenes, those of warm.toml, run through every compiled loop. Kernels that hold the
closures of a scene are compiled with the default closures here, and with others when a
scene first names them, which takes about a second.
"""

from __future__ import annotations

import time
import tomllib
from collections.abc import Iterator
from pathlib import Path

from contbed.loading import load
from contbed.scene.tables import SceneBase


def scenes() -> dict[str, SceneBase]:
    """Return the scenes that run, by the name of their physics."""
    text = Path(__file__).with_name("warm.toml").read_text(encoding="utf-8")
    given = tomllib.loads(text)
    found = {
        name: load(given["bed"], changes) for name, changes in given["variants"].items()
    }
    return found | {"particles in a gas": load(given["particles"])}


def warm() -> Iterator[tuple[str, float]]:
    """Compile what runs need; yields the name of each physics and the CPU time that
    it took [s].
    """
    from contbed.runner import run

    for name, scene in scenes().items():
        start = time.process_time()
        run(scene)
        yield name, time.process_time() - start
