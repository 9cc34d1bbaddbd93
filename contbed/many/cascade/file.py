"""A cascade file: the scene of a packed, moving or bubbling bed whose closures come from packings of particles.

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
    solid.conductivity = "10 %"

`laws.conduction` gives heat.conductivity_solid, `laws.exchange` gives heat.nusselt; of a bubbling bed they give
bubbling_bed.conductivity and the gas_coefficient of each species. What is absent stays as the scene has it, and the
particles are not asked for it. The scene gets the porosity of the packings.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field

from contbed import fields
from contbed.bubbling_bed.scene import BubblingScene
from contbed.closures.binding import bind
from contbed.dem.heat import VORONOI
from contbed.errors import SceneError
from contbed.loading import load, table_of
from contbed.many.cascade.reactor import Reactor, reactor, why_not
from contbed.many.validate.case import Case, names, read_case
from contbed.packed_bed.scene import Scene
from contbed.scene.names import nearest, nearest_of
from contbed.scene.quantities import Length, Number, Pressure, Switch, Table, Whole, form
from contbed.scene.tables import Named
from contbed.scene.toml_lines import Origin, parse_key, read
from contbed.scene.uncertain import uncertain_numbers

AT_PARTICLE = ("Re", "Pr", "eps")  # what a law of exchange is given
Law = Annotated[Named, Discriminator(form)]
Scatter = Annotated[Number, Field(ge=0, lt=1)]


class Packings(Table):
    """Random packings of spheres with periodic sides or between walls, settled by their weight."""

    count: Annotated[Whole, Field(ge=2, le=32)] = 4
    particles: Annotated[Whole, Field(ge=300, le=50_000)] = Field(1000, description="in each")
    width: Annotated[Number, Field(ge=5)] = Field(10.0, description="of the box, in diameters")
    walls: Switch = Field(False, description="square box with walls, whose porosity counts whole; else periodic sides")
    friction: Annotated[Number, Field(ge=0)] = Field(0.3, description="Coulomb's coefficient of sliding")
    seed: Annotated[Whole, Field(ge=0)] = Field(0, description="of the first packing; the next count on")
    diameter: Length | None = Field(None, description="Sauter mean of the spheres; that of the scene if absent")
    spread: Annotated[Number, Field(ge=0, le=0.3)] = Field(
        0.0, description="standard deviation of the radii over their mean; normal, cut at two deviations"
    )
    youngs_modulus: Pressure = Field(5e10, description="of the material, to which contacts are corrected")
    simulated: Pressure = Field(1e7, description="Young's modulus with which the packings settle")


class Laws(Table):
    """Laws of one particle, equally probable where there are several."""

    conduction: tuple[Literal["cones", "columns", "spreading"], ...] = Field(
        (), description="paths of heat between two particles, for the conductivity of the bed at rest"
    )
    exchange: tuple[Law, ...] = Field((), description="Nusselt numbers of a particle in its surroundings")
    scatter_conduction: Scatter = Field(
        0.0, description="standard deviation of measured conductivities of beds about the laws, as a share"
    )
    scatter_exchange: Scatter = Field(
        0.0, description="standard deviation of measured Nusselt numbers of beds about the laws, as a share"
    )


class Settings(Table):
    """The file."""

    kind: ClassVar[str] = "cascade"

    title: str = ""
    scene: str
    qoi: tuple[str, ...] = Field((), description="named results that get a band; needed without `measured`")
    samples: Annotated[Whole, Field(ge=8, le=10_000)] = Field(64, description="runs for the band")
    measured: str | None = Field(None, description="case of `contbed validate`, or its folder, to compare with")
    packings: Packings = Packings()
    laws: Laws
    uncertain: dict[str, Any] = Field(default_factory=dict, description="standard uncertainty by key of the scene")


@dataclass(frozen=True)
class Cascade:
    """What a cascade file asks for; `uncertain` holds key, value and standard uncertainty in SI.

    `reactor` : what the packings give the scene
    `measured` : the bed whose measured points are compared; None if there is none
    """

    path: Path
    settings: Settings
    scene: Scene | BubblingScene
    reactor: Reactor
    uncertain: tuple[tuple[str, float, float], ...]
    measured: Case | None
    trust: bool
    allow_large: bool

    @property
    def scene_file(self) -> Path:
        """The file of the scene."""
        return self.path.parent / self.settings.scene

    @property
    def diameter(self) -> float:
        """Sauter mean diameter of the spheres of the packings [m]."""
        return self.settings.packings.diameter or self.reactor.diameter


def read_cascade(path: str | Path, trust: bool = False, allow_large: bool = False) -> Cascade:
    """Read a cascade file; flags as in `contbed.loading.load`.

    Raises
    ------
    SceneError : with file:line, the mistakes of the file or of its scene
    """
    path = Path(path)
    values, origin = read(path)
    settings: Settings = table_of(Settings, values, origin)
    if not (origin.base / settings.scene).is_file():
        raise SceneError(f'{origin.at(("scene",))}: scene: no such file: "{settings.scene}", looked for beside it')
    scene = load(origin.base / settings.scene, trust=trust, allow_large=allow_large)
    problems = list(_mistakes(settings, scene, origin))
    if problems:
        raise SceneError(problems)
    assert isinstance(scene, Scene | BubblingScene)
    uncertain = tuple(uncertain_numbers(settings.uncertain, scene, origin))
    if problems := list(_impossible(settings, uncertain, origin, {"trust": trust, "allow_large": allow_large})):
        raise SceneError(problems)
    measured = _measured(settings, scene, origin)
    return Cascade(path, settings, scene, reactor(scene), uncertain, measured, trust, allow_large)


def _impossible(
    settings: Settings, uncertain: Iterable[tuple[str, float, float]], origin: Origin, flags: Mapping[str, bool]
) -> Iterator[str]:
    """Say which standard uncertainties reach values that a scene refuses."""
    for key, value, uncertainty in uncertain:
        for end in (value - uncertainty, value + uncertainty):
            try:
                load(origin.base / settings.scene, {key: end}, **flags)
            except SceneError as error:
                where = f"{origin.at(('uncertain', *parse_key(key)))}: uncertain.{key}"
                text = error.problems[0].removeprefix("override: ")
                yield f"{where}: {uncertainty:g} around {value:g} reaches what the scene refuses: {text}"
                break


def _measured(settings: Settings, scene: Scene | BubblingScene, origin: Origin) -> Case | None:
    """Return the measured bed.

    Raises
    ------
    SceneError : there is no such case, it has no profiles, or the scene is steady
    """
    if settings.measured is None:
        return None
    where = f"{origin.at(('measured',))}: measured"
    folder = origin.base / settings.measured
    if not (folder / "case.toml").is_file() and settings.measured not in names():
        raise SceneError(f'{where}: no case "{settings.measured}"; {nearest(settings.measured, names())}')
    case = read_case(settings.measured if settings.measured in names() else str(folder))
    if case.settings.compare != "profiles":
        raise SceneError(f"{where}: the case compares {case.settings.compare}, a cascade only profiles")
    if scene.time is None:
        raise SceneError(f"{where}: the points are measured over time, but the scene is steady; give it a [time]")
    return case


def _mistakes(settings: Settings, scene: Any, origin: Origin) -> Iterator[str]:
    if why := why_not(scene):
        yield f"{origin.at(('scene',))}: scene: {why}"
        return
    if not settings.laws.conduction and not settings.laws.exchange:
        yield f"{origin.at(('laws',))}: laws: asks nothing of the particles; give conduction, exchange, or both"
    for name in ("conduction", "exchange"):
        if getattr(settings.laws, f"scatter_{name}") and not getattr(settings.laws, name):
            yield f"{origin.at(('laws', f'scatter_{name}'))}: laws.scatter_{name}: there is no law of {name} to scatter"
    if settings.packings.walls and settings.laws.exchange:
        why = "the gas is computed between periodic sides only; leave out walls, or laws.exchange"
        yield f"{origin.at(('packings', 'walls'))}: packings.walls: {why}"
    for paths in settings.laws.conduction:
        if paths not in VORONOI or settings.packings.spread == 0.0:
            continue
        why = f'{paths} are for equal spheres; take "cones", or packings.spread = 0'
        yield f"{origin.at(('laws', 'conduction'))}: laws.conduction: {why}"
    if not settings.qoi and settings.measured is None:
        yield f"{origin.at(('qoi',))}: qoi: asks for no result; name one, such as T_fluid_out_K, or give `measured`"
    for k, law in enumerate(settings.laws.exchange):
        try:
            bind(law, "nusselt", AT_PARTICLE)
        except SceneError as error:
            yield f"{origin.at(('laws', 'exchange'))}: laws.exchange[{k}]: {error}"
    for name in settings.qoi:
        if fields.unit_of(name) is None:
            yield f"{origin.at(('qoi',))}: qoi: no named result {name!r}; {nearest_of(name, list(fields.RESULTS))}"
