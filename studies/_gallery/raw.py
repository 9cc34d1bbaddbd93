"""What is too large to commit: a study leaves fields and checkpoints here, draws
them and goes on where they are.
"""

from __future__ import annotations

from pathlib import Path

import contbed as cb

RESULTS = Path(__file__).parents[2] / "results" / "studies"


def raw(study: str) -> Path:
    """Folder of the fields of a study, not under version control; it may not exist."""
    return RESULTS / study


def resumed(scene: cb.Scene, folder: Path) -> cb.Result:
    """Run a scene, or go on with what the folder holds of it."""
    return cb.run(
        scene, folder, restart=folder if (folder / "checkpoint.npz").is_file() else None
    )
