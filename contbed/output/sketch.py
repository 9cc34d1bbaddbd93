"""A sketch of the bed with its streams, from the tables of a scene: what fills it, what
enters and leaves, and which sides exchange heat.

`contbed plan` and the report show it, so that a user sees at one glance whether this is
the reactor that was meant.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

Table = Mapping[str, Any]

OPPOSITE = {"bottom": "top", "top": "bottom", "left": "right", "right": "left"}
# the side of a boundary of a mesh file, by a part of its name
SIDES = {
    "bottom": "bottom",
    "top": "top",
    "left": "left",
    "right": "right",
    "outlet": "top",
    "inlet": "bottom",
}
FLOWS = {
    "velocity": "m/s",
    "mass_flow": "kg/s",
    "mass_flux": "kg/m2/s",
    "molar_flux": "mol/m2/s",
    "capacity_flow": "W/K",
}
TEMPERATURES = ("temperature", "fixed_temperature")
MODELS = ("packed_bed", "reacting_bed", "bubbling_bed", "two_fluid", "particles_gas")
WIDTH = 34  # characters of the box in a terminal


@dataclass(frozen=True)
class Stream:
    """What crosses a side: a phase that enters or leaves, or heat (`inward` None)."""

    side: str
    text: str
    inward: bool | None = None


@dataclass(frozen=True)
class Sketch:
    """What a bed holds, one line for each, and its streams."""

    inside: tuple[str, ...]
    streams: tuple[Stream, ...]
    horizontal: bool

    def at(self, side: str) -> list[Stream]:
        """Return the streams of a side."""
        return [stream for stream in self.streams if stream.side == side]


def sketch(model: str, scene: Table, results: Table | None = None) -> Sketch | None:
    """Return the sketch of a scene; None for a model that has no bed with sides.

    Parameters
    ----------
    model : the name of the model
    scene : its tables, values in SI
    results : named results, whose outlet temperatures are shown
    """
    if model not in MODELS:
        return None
    mesh = scene.get("mesh") or {}
    streams = [
        stream
        for name, table in (scene.get("boundary") or {}).items()
        for stream in _streams(_side(name), name, table)
    ]
    streams += list(_leaving(streams, results or {}))
    streams += list(_feeds_and_tubes(scene))
    return Sketch(
        tuple(_inside(scene)), tuple(streams), horizontal=mesh.get("type") == "line"
    )


def text_of(bed: Sketch) -> str:
    """Return a sketch as lines of text: a box with the streams around it."""
    ends = ("left", "right") if bed.horizontal else ("top", "bottom")
    sides = [side for side in ("wall", *OPPOSITE) if side not in ends]
    beside = [_line(stream) for side in sides for stream in bed.at(side)]
    rows = max(len(bed.inside), len(beside))
    inside = [*bed.inside, *[""] * (rows - len(bed.inside))]
    beside += [""] * (rows - len(beside))
    edge = "  +" + "-" * (WIDTH + 2) + "+"
    above, below = (
        [f"    {end:7}{_line(stream)}" for stream in bed.at(end)] for end in ends
    )
    box = [
        f"  | {text:{WIDTH}} |  {side}".rstrip()
        for text, side in zip(inside, beside, strict=True)
    ]
    return "\n".join([*above, edge, *box, edge, *below])


def _line(stream: Stream) -> str:
    way = {True: "in:  ", False: "out: ", None: ""}[stream.inward]
    return way + stream.text


def _side(name: str) -> str:
    return next((side for part, side in SIDES.items() if part in name), "wall")


def _inside(scene: Table) -> Iterator[str]:
    size = _size(scene)
    if size:
        yield size
    porosity = (scene.get("packed_bed") or {}).get("porosity")
    if isinstance(porosity, int | float):
        yield f"porosity {porosity:.3g}"
    for name, solid in (scene.get("solids") or {}).items():
        diameter = solid.get("diameter")
        known = isinstance(diameter, int | float)
        yield f"{name}, {1e3 * diameter:.4g} mm" if known else name
    reactions = list(scene.get("reactions") or {})
    if reactions:
        names = ", ".join(reactions)
        fits = len(names) <= WIDTH
        yield names if fits else f"{len(reactions)} reactions"


def _size(scene: Table) -> str:
    mesh = scene.get("mesh") or {}
    bed = scene.get("bubbling_bed") or {}
    lengths = [mesh.get(key) for key in ("diameter", "radius", "length", "height")]
    if mesh.get("type") == "line":
        return f"{mesh['length']:.4g} m long"
    if bed.get("height"):
        return f"{bed['height']:.4g} m high"
    sizes = [f"{length:.4g} m" for length in lengths if isinstance(length, int | float)]
    if sizes:
        return " by ".join(sizes)
    return str(mesh.get("file", "")).rpartition("/")[2]


def _streams(side: str, name: str, table: Table) -> Iterator[Stream]:
    """Yield what the table of a boundary says: streams that enter, and heat."""
    for phase, given in {
        "gas": table.get("gas"),
        **(table.get("solids") or {}),
    }.items():
        flow = next(
            ((key, given[key]) for key in FLOWS if given and key in given), None
        )
        if flow is not None and _enters(side, flow[1]):
            parts = [_temperature(given), _amount(*flow)]
            text = ", ".join(part for part in parts if part)
            yield Stream(side, f"{phase} {text}", inward=True)
    if "coefficient" in table and "ambient" in table:
        coefficient, ambient = table["coefficient"], table["ambient"]
        shown = (_number(coefficient, "W/m2/K"), _number(ambient, "K"))
        yield Stream(side, f"{name}: {shown[0]} to {shown[1]}")
    elif "heat_flux" in table:
        yield Stream(side, f"{name}: {_number(table['heat_flux'], 'W/m2')}")
    elif _temperature(table):
        yield Stream(side, f"{name}: {_temperature(table)}")


def _feeds_and_tubes(scene: Table) -> Iterator[Stream]:
    """Yield the feeds of solids of a bubbling bed and what its tubes take up."""
    for name, solid in (scene.get("solids") or {}).items():
        feed = solid.get("feed") or {}
        if feed.get("mass_flow"):
            parts = (_temperature(feed), _amount("mass_flow", feed["mass_flow"]))
            yield Stream("wall", f"{name} {', '.join(parts)}", inward=True)
    tubes = (scene.get("bubbling_bed") or {}).get("tubes") or {}
    if _temperature(tubes):
        yield Stream("wall", f"tubes: {_temperature(tubes)}")


def _leaving(streams: list[Stream], results: Table) -> Iterator[Stream]:
    """Yield the outlet of each phase, opposite to where it enters."""
    for stream in streams:
        if stream.inward and stream.side in OPPOSITE:
            phase = stream.text.partition(" ")[0]
            keys = ("T_fluid_out_K", "T_gas_out_K")
            if phase != "gas":
                keys = (f"T_solid_{phase}_out_K", "T_solid_out_K")
            known = [results[key] for key in keys if results.get(key) is not None]
            text = f"{phase} {_number(known[0], 'K')}" if known else phase
            yield Stream(OPPOSITE[stream.side], text, inward=False)


def _enters(side: str, value: Any) -> bool:
    """Return whether a stream enters; a number counts inward, a vector by its axis."""
    if isinstance(value, list):
        along = value[0] if side in ("left", "right") else value[-1]
        inward = along if side in ("left", "bottom") else -along
        return bool(inward > 0.0)
    return not isinstance(value, int | float) or value > 0.0


def _amount(key: str, value: Any) -> str:
    if isinstance(value, list):
        value = max(map(abs, value))
    return _number(value, FLOWS[key])


def _temperature(table: Table) -> str:
    found = next((table[key] for key in TEMPERATURES if key in table), None)
    return "" if found is None else _number(found, "K")


def _number(value: Any, unit: str) -> str:
    if isinstance(value, int | float):
        return f"{value:.4g} {unit}"
    if isinstance(value, str):
        return value
    return "varying"
