"""Numbers of a scene that are not known exactly: a table of standard uncertainties, in
SI or as a share.

[uncertain]
packed_bed.porosity = 0.01
solids.pebbles.conductivity = "20 %"
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from contbed.errors import SceneError
from contbed.scene.toml_lines import Origin, parse_key
from contbed.scene.values import flat, number_at

_PERCENT = re.compile(r"\s*([0-9.eE+-]+)\s*%\s*")


def share_of(given: Any) -> float | None:
    """Return the share that a text like "5 %" gives; None for anything else."""
    found = _PERCENT.fullmatch(given) if isinstance(given, str) else None
    return None if found is None else float(found[1]) / 100.0


def uncertain_numbers(
    table: Mapping[str, Any], scene: Any, origin: Origin
) -> Iterator[tuple[str, float, float]]:
    """Yield key, value and standard uncertainty in SI of a table `uncertain` about a
    scene.

    Raises
    ------
    SceneError : a key that the scene does not have as a number, or an uncertainty that
        is none
    """
    for path, given in flat(table):
        key = ".".join(path)
        where = f"{origin.at(('uncertain', *parse_key(key)))}: uncertain.{key}"
        value = number_at(scene, key)
        if value is None:
            raise SceneError(f"{where}: the scene has no number under this key")
        share = share_of(given)
        number = (
            isinstance(given, int | float)
            and not isinstance(given, bool)
            and 0 < given < math.inf
        )
        if share is None and not number:
            raise SceneError(
                f'{where}: expected a number > 0 in SI, or a share like "5 %"'
            )
        yield (
            key,
            value,
            share * abs(value) if share is not None else float(given),
        )
