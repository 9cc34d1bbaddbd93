"""A cascade file: the scene of a packed, moving or bubbling bed whose closures come
from packings of particles.

    title = "From pebbles to the outlet of a heater"
    scene = "heater.toml"
    qoi = ["T_fluid_out_K", "pressure_drop_Pa"]
    samples = 64                             # runs with everything uncertain at once, for the band

    measured = "beaulieu_2020"               # a case of `contbed validate`, if any: share of its points in the band

    [packings]                               # of spheres as large as the scene's
    count = 4
    particles = 1000
    youngs_modulus = "50 GPa"                # of the material; the packings are settled with `simulated`

    [laws]                                   # what is believed of one particle; more than one: a part of the band
    conduction = ["cones", "columns"]
    exchange = [{ name = "power", a = 1.2, b = 0.5 }, "gunn"]
    scatter_conduction = "15 %"              # of measured beds about the laws: what all of them may miss

    [uncertain]                              # standard uncertainty of numbers of the scene, in SI or as a share
    solids.pebbles.conductivity = "10 %"

`laws.conduction` gives closures.conductivity_solids, `laws.exchange` closures.nusselt;
of a bubbling bed they give bubbling_bed.conductivity and the nusselt of each solid
phase. What is absent stays as the scene has it, and the particles are not asked for it.
The scene gets the porosity of the packings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from math import pi
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field

from contbed.bubbling_bed.scene import BubblingScene
from contbed.closures.binding import bind
from contbed.dem.checks import LOWEST
from contbed.dem.heat import VORONOI
from contbed.dem.scene import SOLID_SHARE
from contbed.errors import SceneError
from contbed.loading import load
from contbed.many.cascade.reactor import Reactor, reactor, why_not
from contbed.many.quantities import why_unknown
from contbed.many.study_file import StudyFile
from contbed.many.validate.case import Case, names, read_case
from contbed.packed_bed.scene import Scene
from contbed.scene.names import nearest
from contbed.scene.quantities import (
    Length,
    Natural,
    NonNegative,
    Number,
    Pressure,
    ShareBelowOne,
    Switch,
    Table,
    Whole,
    form,
)
from contbed.scene.tables import Named, SceneBase
from contbed.scene.toml_lines import parse_key
from contbed.scene.uncertain import uncertain_numbers

AT_PARTICLE = ("Re", "Pr", "eps")  # what a law of exchange is given
Law = Annotated[Named, Discriminator(form)]
Scatter = ShareBelowOne


class Packings(Table):
    """Random packings of spheres with periodic sides or between walls, settled by
    their weight.
    """

    count: Annotated[Whole, Field(ge=2, le=32)] = 4
    """number of random packings"""
    particles: Annotated[Whole, Field(ge=300, le=50_000)] = 1000
    """in each"""
    width: Annotated[Number, Field(ge=5)] = 10.0
    """of the box, in diameters"""
    walls: Switch = False
    """square box with walls, whose porosity counts whole; else periodic sides"""
    friction: NonNegative = 0.3
    """Coulomb's coefficient of sliding"""
    seed: Natural = 0
    """of the first packing; the next count on"""
    diameter: Length | None = None
    """Sauter mean of the spheres; that of the scene if absent"""
    spread: Annotated[Number, Field(ge=0, le=0.3)] = 0.0
    """standard deviation of the radii over their mean; normal, cut at two deviations"""
    youngs_modulus: Pressure = 5e10
    """of the material, to which contacts are corrected"""
    simulated: Pressure = 1e7
    """Young's modulus with which the packings settle"""

    @property
    def expected_height(self) -> float:
        """Height of a settled packing over the diameter, about."""
        return self.particles * pi / 6.0 / (SOLID_SHARE * self.width**2)


class Laws(Table):
    """Laws of one particle, equally probable where there are several."""

    conduction: tuple[Literal["cones", "columns", "spreading"], ...] = ()
    """paths of heat between two particles, for the conductivity of the bed at rest"""
    exchange: tuple[Law, ...] = ()
    """Nusselt numbers of a particle in its surroundings"""
    scatter_conduction: Scatter = 0.0
    """standard deviation of measured conductivities of beds about the laws, as a share
    """
    scatter_exchange: Scatter = 0.0
    """standard deviation of measured Nusselt numbers of beds about the laws, as a share
    """


class Settings(Table):
    """The file."""

    kind: ClassVar[str] = "cascade"

    title: str = ""
    """title of the study, shown in plots and reports"""
    scene: str
    """scene file, path relative to this file"""
    qoi: tuple[str, ...] = ()
    """named results that get a band; needed without `measured`"""
    samples: Annotated[Whole, Field(ge=8, le=10_000)] = 64
    """runs for the band"""
    measured: str | None = None
    """case of `contbed validate`, or its folder, to compare with"""
    packings: Packings = Packings()
    """random packings that are settled"""
    laws: Laws
    """closures that the packings replace"""
    uncertain: dict[str, Any] = Field(default_factory=dict)
    """standard uncertainty by key of the scene"""


@dataclass(frozen=True)
class Cascade:
    """What a cascade file asks for; `uncertain` holds key, value and standard
    uncertainty in SI.

    `reactor` : what the packings give the scene
    `measured` : the bed whose measured points are compared; None if there is none
    `load` : returns the scene with other values
    """

    path: Path
    settings: Settings
    scene: Scene | BubblingScene
    reactor: Reactor
    uncertain: tuple[tuple[str, float, float], ...]
    measured: Case | None
    load: Callable[..., SceneBase]

    @property
    def scene_file(self) -> Path:
        """The file of the scene."""
        return self.path.parent / self.settings.scene

    @property
    def diameter(self) -> float:
        """Sauter mean diameter of the spheres of the packings [m]."""
        return self.settings.packings.diameter or self.reactor.diameter


def read_cascade(
    path: str | Path, trust: bool = False, allow_large: bool = False
) -> Cascade:
    """Read a cascade file; flags as in `contbed.loading.load`.

    Raises
    ------
    SceneError : with file:line, the mistakes of the file or of its scene
    """
    file = StudyFile(path, Settings)
    settings = file.settings
    scene_file = file.file(("scene",), settings.scene)
    file.stop()
    make = partial(load, scene_file, trust=trust, allow_large=allow_large)
    scene = make()
    _note_mistakes(file, scene)
    file.stop()
    assert isinstance(scene, Scene | BubblingScene)
    uncertain = tuple(uncertain_numbers(settings.uncertain, scene, file.origin))
    _note_impossible(file, uncertain, make)
    file.stop()
    measured = _measured(file, scene)
    return Cascade(
        file.path,
        settings,
        scene,
        reactor(scene),
        uncertain,
        measured,
        make,
    )


def _note_impossible(
    file: StudyFile[Settings],
    uncertain: Iterable[tuple[str, float, float]],
    make: Callable[..., SceneBase],
) -> None:
    """Note the standard uncertainties that reach values that the scene refuses."""
    for key, value, uncertainty in uncertain:
        for end in (value - uncertainty, value + uncertainty):
            try:
                make({key: end})
            except SceneError as error:
                reason = error.problems[0].removeprefix("override: ")
                text = (
                    f"{uncertainty:g} around {value:g} reaches what the scene "
                    f"refuses: {reason}"
                )
                file.say(("uncertain", *parse_key(key)), text, f"uncertain.{key}")
                break


def _measured(file: StudyFile[Settings], scene: Scene | BubblingScene) -> Case | None:
    """Return the measured bed.

    Raises
    ------
    SceneError : there is no such case, it has no profiles, or the scene is steady
    """
    name, at = file.settings.measured, ("measured",)
    if name is None:
        return None
    folder = file.origin.base / name
    if not (folder / "case.toml").is_file() and name not in names():
        file.fail(at, f'no case "{name}"; {nearest(name, names())}')
    case = read_case(name if name in names() else str(folder))
    if case.settings.compare != "profiles":
        file.fail(
            at, f"the case compares {case.settings.compare}, a cascade only profiles"
        )
    if scene.time is None:
        file.fail(
            at,
            "the points are measured over time, but the scene is steady; give it a "
            "[time]",
        )
    return case


def _note_mistakes(file: StudyFile[Settings], scene: SceneBase) -> None:
    """Note what the file asks for and its scene or its packings cannot give."""
    settings, laws = file.settings, file.settings.laws
    if why := why_not(scene):
        file.say(("scene",), why)
        return
    if not laws.conduction and not laws.exchange:
        file.say(
            ("laws",),
            "asks nothing of the particles; give conduction, exchange, or both",
        )
    for name in ("conduction", "exchange"):
        if getattr(laws, f"scatter_{name}") and not getattr(laws, name):
            file.say(
                ("laws", f"scatter_{name}"), f"there is no law of {name} to scatter"
            )
    if settings.packings.walls and laws.exchange:
        text = (
            "the gas is computed between periodic sides only; leave out walls, or "
            "laws.exchange"
        )
        file.say(("packings", "walls"), text)
    height = settings.packings.expected_height
    if height < LOWEST:
        text = (
            f"make a bed about {height:.2g} diameters high; {LOWEST:g} are needed: give "
            "more particles, or a smaller width"
        )
        file.say(("packings", "particles"), text)
    for paths in laws.conduction:
        if paths in VORONOI and settings.packings.spread:
            text = (
                f'{paths} are for equal spheres; take "cones", or packings.spread = 0'
            )
            file.say(("laws", "conduction"), text)
    if not settings.qoi and settings.measured is None:
        file.say(
            ("qoi",),
            "asks for no result; name one, such as T_fluid_out_K, or give `measured`",
        )
    for k, law in enumerate(laws.exchange):
        try:
            bind(law, "nusselt", AT_PARTICLE)
        except SceneError as error:
            file.say(("laws", "exchange", k), str(error))
    for name in settings.qoi:
        if why := why_unknown(name):
            file.say(("qoi",), why)
