"""Which closure for a place of a scene: those of its kind in order of how well given
conditions lie in their ranges.
"""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from contbed.closures import registry
from contbed.closures.arguments import ARGUMENTS
from contbed.closures.sheet import Interval
from contbed.errors import SceneError
from contbed.explain.closure_keys import closure_keys, kinds_by_model
from contbed.scene.names import nearest

GRAVITY = 9.81  # [m/s2]
LOOSE = 0.4  # porosity of a bed at minimum fluidization
AMBIENT = 101325.0  # [Pa]
AIR = "N2:0.79, O2:0.21"
ALIASES = {
    "rho_s": "rho_solid",
    "rho_p": "rho_solid",
    "rho_g": "rho_gas",
    "k_s": "k_solid",
    "k_f": "k_fluid",
}
SAME = (("rho", "rho_gas"), ("k_fluid", "k_gas"))  # one quantity under two names
# relative difference of two values of one quantity that is no more than rounding of
# what is written
ROUNDED = 1e-3
_PAIR = re.compile(r"\s*([A-Za-z_]\w*)\s*=\s*(.+?)\s*")


# what follows from other arguments, in this order
FOLLOWING: dict[str, tuple[tuple[str, ...], Callable[..., float]]] = {
    "nu": (("mu", "rho"), lambda mu, rho: mu / rho),
    "Pr": (("mu", "cp_gas", "k_fluid"), lambda mu, cp, k: mu * cp / k),
    "Re": (("u", "d_p", "nu"), lambda u, d_p, nu: abs(u) * d_p / nu),
    "Pe": (("Re", "Pr"), lambda Re, Pr: Re * Pr),
    "Ar": (
        ("d_p", "rho_solid", "rho", "mu"),
        lambda d_p, solid, rho, mu: d_p**3 * rho * (solid - rho) * GRAVITY / mu**2,
    ),
    "eps_s": (("eps",), lambda eps: 1.0 - eps),
    "eps": (("eps_s",), lambda eps_s: 1.0 - eps_s),
}
Spans = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Choice:
    """A closure at given conditions: arguments inside and outside of its range,
    those unknown, and its value.
    """

    name: str
    inside: tuple[str, ...]
    outside: tuple[str, ...]
    unknown: tuple[str, ...]
    # sum over the arguments outside of the logarithm of how far they are beyond the
    # bound
    distance: float
    value: float | None

    @property
    def order(self) -> tuple[Any, ...]:
        """Key to sort by: nothing outside first, then most known ranges, then the
        name.
        """
        return (
            bool(self.outside),
            self.distance,
            len(self.unknown),
            -len(self.inside),
            self.name,
        )


def conditions(text: str) -> dict[str, float]:
    """Return the arguments of closures in SI that a text such as "d_p=300 um, T=850
    degC" gives.

    Raises
    ------
    SceneError : a part is no NAME=VALUE, a name or a unit is not known, a value is out
        of the bounds of its argument, or two values contradict each other
    """
    found: dict[str, float] = {}
    for part in re.split(r"[,;]\s*(?=[A-Za-z_]\w*\s*=)", text.strip()):
        match = _PAIR.fullmatch(part)
        if match is None:
            raise SceneError(f"--at: {part!r} is no NAME=VALUE such as d_p=300 um")
        name = ALIASES.get(match[1], match[1])
        if name not in ARGUMENTS:
            raise SceneError(
                f"--at: {match[1]!r} is no argument of a closure; "
                f"{nearest(name, sorted(ARGUMENTS))}"
            )
        if name in found:
            raise SceneError(f"--at: {name} is given twice; give it once")
        found[name] = _in_si(name, match[2])
    _contradictions(found)
    return found


def _contradictions(found: Mapping[str, float]) -> None:
    """Raise SceneError where one quantity has two values."""
    if {"eps", "eps_s"} <= found.keys() and not math.isclose(
        found["eps"] + found["eps_s"], 1.0, rel_tol=ROUNDED
    ):
        told = f"eps = {found['eps']:g} and eps_s = {found['eps_s']:g}"
        raise SceneError(f"--at: {told} must sum to 1; give one of them")
    for pair in SAME:
        if set(pair) <= found.keys() and not math.isclose(
            *(found[name] for name in pair), rel_tol=ROUNDED
        ):
            told = " and ".join(f"{name} = {found[name]:g}" for name in reversed(pair))
            raise SceneError(f"--at: {told} are one quantity; give one of them")


def derived(given: Mapping[str, float]) -> tuple[dict[str, float], str]:
    """Return the conditions with what follows from them, and a remark on what was
    assumed.

    With a temperature and no viscosity the gas is air at `p` or ambient pressure. Then
    k_fluid, Pr, Re, Pe and Ar follow where d_p, u and rho_solid are given.
    """
    known = dict(given)
    remark = ""
    if "T" in known and "mu" not in known:
        from contbed.materials import gas_mixture

        p, T = known.get("p", AMBIENT), known["T"]
        air = gas_mixture(AIR, p)
        for name, value in (
            ("rho", air.density(T)),
            ("mu", air.viscosity(T)),
            ("k_fluid", air.conductivity(T)),
            ("cp_gas", air.heat_capacity(T)),
        ):
            known.setdefault(name, float(value))
        remark = f"gas: air at {T:g} K and {p:g} Pa, as mu is not given"
    for one, other in SAME:
        if one in known or other in known:
            value = known.get(one, known.get(other))
            assert value is not None
            known[one] = known[other] = value
    for name, (needed, value) in FOLLOWING.items():
        if name not in known and known.keys() >= set(needed):
            known[name] = value(*map(known.get, needed))
    if known.get("Ar", 1.0) <= 0.0:  # what floats has none
        del known["Ar"]
    return known, remark


def kind_for(place: str) -> str:
    """Return the kind of closure that a place of a scene takes, "closures.drag"; or the
    kind itself, "drag".

    Raises
    ------
    SceneError : there is no such place or kind
    """
    kinds = sorted({registry.sheet(name).kind for name in registry.names()})
    if place in kinds:
        return place
    known = closure_keys()
    if (pattern := _pattern(place)) in known:
        return known[pattern]
    raise SceneError(
        f"--for: no place {place!r} takes a closure; {nearest(place, [*known, *kinds])}"
    )


def _pattern(place: str) -> str:
    """Return a key with NAME for the name of a table."""
    return re.sub(r"^(solids|boundary|region)\.[^.]+", r"\1.NAME", place)


def fluidized(known: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """Return the Reynolds numbers and porosities that gas and particles of a fluidized
    bed meet; empty without Ar.

    Re goes from minimum fluidization (Grace 1982) to the terminal velocity (Haider and
    Levenspiel 1989), eps from a loose packing to the single particle.
    """
    if not {"Ar", "d_p", "rho_solid", "rho", "mu"} <= known.keys():
        return {}
    least = float(registry.get("minimum_fluidization_grace")(Ar=known["Ar"]))
    arguments = inspect.signature(
        terminal := registry.get("terminal_velocity_haider_levenspiel")
    ).parameters
    sphere = {"sphericity": 1.0} | dict(known)
    u_t = float(terminal(**{key: sphere[key] for key in arguments}))
    return {
        "Re": (least, u_t * known["d_p"] * known["rho"] / known["mu"]),
        "eps": (LOOSE, 1.0),
    }


def ranked(
    kind: str, known: Mapping[str, float], spans: Spans | None = None
) -> list[Choice]:
    """Return the closures of a kind, those first whose ranges hold the conditions
    and `spans`, low and high of each.
    """
    every = _every(known, spans or {})
    choices = [_choice(name, known, every) for name in registry.names(kind)]
    return sorted(choices, key=lambda choice: choice.order)


def _every(known: Mapping[str, float], spans: Spans) -> Spans:
    """Return low and high of all that is known."""
    return {**spans, **{name: (value, value) for name, value in known.items()}}


def table(place: str, at: str | None) -> str:
    """Return the closures for a place of a scene at the conditions `at` as lines for
    a terminal.
    """
    kind = kind_for(place)
    given = conditions(at) if at else {}
    known, remark = derived(given)
    unit = registry.sheet(registry.names(kind)[0]).unit
    lines = [f"closures of kind {kind} [{unit}], the best covered first"]
    lines += [
        f"{model} takes those of kind {other}: contbed closures --for {other}"
        for model, other in kinds_by_model(_pattern(place)).items()
        if other != kind
    ]
    shown = {name: f"{name} = {value:.4g}" for name, value in known.items()}
    follows = [text for name, text in shown.items() if name not in given]
    if given:
        lines.append("at " + ", ".join(shown[name] for name in given))
    if given and remark:
        lines.append(remark)
    if given and follows:
        lines.append(f"hence {', '.join(follows)}")
    spans = fluidized(known) if kind == "drag" else {}
    spans = {key: span for key, span in spans.items() if key not in known}
    if spans:
        ends = ", ".join(
            f"{key} = {low:.4g} to {high:.4g}" for key, (low, high) in spans.items()
        )
        lines.append(f"from minimum fluidization to the terminal velocity {ends}")
    every = _every(known, spans)
    lines.append("")
    for choice in ranked(kind, known, spans):
        value = "" if choice.value is None else f"  = {choice.value:.5g}"
        gives_u_mf = kind == "minimum_fluidization" and {"nu", "d_p"} <= known.keys()
        if choice.value is not None and gives_u_mf:
            u_mf = choice.value * known["nu"] / known["d_p"]
            value += f", u_mf = {u_mf:.5g} m/s"
        lines.append(f"{choice.name:42}{_verdict(choice, bool(given)):10}{value}")
        outside = [_with_range(choice.name, key, every) for key in choice.outside]
        if outside:
            lines.append(f"    outside: {', '.join(outside)}")
        unknown = _unknown(choice, every) if given else []
        if unknown:
            lines.append(f"    not known: {', '.join(unknown)}")
        lines.append(f"    {registry.sheet(choice.name).summary}")
    return "\n".join(lines)


def _unknown(choice: Choice, known: Spans) -> list[str]:
    """Return what is not known: parts of the range, and of the value where there is
    none.
    """
    unknown = list(choice.unknown)
    if choice.value is None:
        arguments = registry.sheet(choice.name).arguments
        unknown += [key for key in arguments if key not in (*known, *unknown)]
    return unknown


def _verdict(choice: Choice, given: bool) -> str:
    if not given:
        return ""
    if choice.outside:
        return "outside"
    return "inside" if choice.inside else "unknown"


def _choice(name: str, known: Mapping[str, float], spans: Spans) -> Choice:
    sheet = registry.sheet(name)
    inside: list[str] = []
    outside: list[str] = []
    unknown: list[str] = []
    distance = 0.0
    for key, (low, high) in sheet.ranges.items():
        if any(part not in spans for part in key.split("/")):
            unknown.append(key)
            continue
        beyond = [
            _beyond(value, low, high)
            for value in _of(key, spans)
            if not low <= value <= high
        ]
        (outside if beyond else inside).append(key)
        distance += sum(beyond)
    return Choice(
        name,
        tuple(inside),
        tuple(outside),
        tuple(unknown),
        distance,
        _value(name, known),
    )


def _of(key: str, spans: Spans) -> tuple[float, float]:
    """Return the lowest and highest value of an argument or of a ratio of two."""
    first, *second = key.split("/")
    if not second:
        return spans[first]
    (low, high), (least, most) = spans[first], spans[second[0]]
    return low / most, high / least


def _beyond(value: float, low: float, high: float) -> float:
    """Return how far a value is beyond its bound, as the logarithm of their ratio; 1
    where a bound is zero.
    """
    bound = low if value < low else high
    return abs(math.log(value / bound)) if value > 0.0 and bound > 0.0 else 1.0


def _value(name: str, known: Mapping[str, float]) -> float | None:
    """Return the value of a closure whose arguments are all known."""
    function = registry.get(name)
    arguments = {
        key: known[key]
        for key in inspect.signature(function).parameters
        if key in known
    }
    if any(key not in arguments for key in registry.sheet(name).arguments):
        return None
    value = function(**arguments)
    return (
        float(value)
        if isinstance(value, int | float) or getattr(value, "ndim", 1) == 0
        else None
    )


def _with_range(name: str, key: str, spans: Spans) -> str:
    low, high = registry.sheet(name).ranges[key]
    used = " to ".join(dict.fromkeys(f"{value:.4g}" for value in _of(key, spans)))
    return f"{key} = {used} (range {low:g} to {high:g})"


def _in_si(name: str, text: str) -> float:
    """Return a value in the SI unit of an argument, within its bounds."""
    known = ARGUMENTS[name]
    try:
        value = float(text)
    except ValueError:
        from contbed.scene.units import to_si

        try:
            value = to_si(text, "1" if known.unit == "-" else known.unit)
        except ValueError as error:
            raise SceneError(f"--at: {name} = {text}: {error}") from None
    if known.bounds and value not in Interval.read(known.bounds):
        shown = f"{value:g}" if known.unit == "-" else f"{value:g} {known.unit}"
        raise SceneError(
            f"--at: {name} = {text}: {shown}; {known.meaning} must be in {known.bounds}"
        )
    if not math.isfinite(value):
        raise SceneError(
            f"--at: {name} = {text}: {known.meaning} must be a finite number"
        )
    return value
