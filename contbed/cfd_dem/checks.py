"""What is wrong with a scene of particles in a gas although every single value is right."""

from __future__ import annotations

from contbed.cfd_dem import scene as g
from contbed.cfd_dem.closures import GIVES
from contbed.closures.binding import bind
from contbed.dem.dumps import is_dump
from contbed.errors import SceneError
from contbed.scene.checking import Mistakes, See
from contbed.scene.tables import FluidCantera, FluidConstant
from contbed.scene.toml_lines import Origin


def one_source(particles: g.GasParticles, origin: Origin, see: See) -> Mistakes:
    """Require either a count or a file of particles, with all that it needs."""
    if (particles.count is None) == (particles.file is None):
        yield ("particles",), "give either count, to settle a bed, or file"
    if particles.file is None:
        if particles.radius is None:
            yield ("particles", "radius"), "missing; settled spheres need it"
        elif 2.0 * particles.radius > min(particles.width):
            yield ("particles", "width"), f"narrower than a sphere; see {see('particles.radius')}"
        return
    path = origin.base / particles.file
    if "\0" in particles.file or not path.is_file():
        yield ("particles", "file"), f"no such file; looked for {path.absolute()}"
    elif particles.radius is None and not is_dump(path):
        yield ("particles", "radius"), f"missing; {particles.file} has none"


def fluid_is_complete(fluid: FluidConstant | FluidCantera) -> Mistakes:
    """Require heat capacity and conductivity of a fluid of constant properties."""
    if isinstance(fluid, FluidConstant):
        for name in ("heat_capacity", "conductivity"):
            if not getattr(fluid, name):
                yield ("fluid", name), "missing or 0; heat transfer coefficients need it"


def closures_exist(gas: g.GasFlow, origin: Origin) -> Mistakes:
    """Require closures that exist and whose arguments the gas around a particle gives."""
    for kind, gives in GIVES.items():
        try:
            bind(getattr(gas, kind), kind, gives, origin.base)
        except SceneError as error:
            yield ("gas", kind), str(error)


def jet_is_in_the_floor(gas: g.GasFlow, particles: g.GasParticles, see: See) -> Mistakes:
    """Require that the slot of the jet lies in the floor of the bed."""
    if gas.jet is None:
        return
    low, high = gas.jet.slot
    if not 0.0 <= low < high <= particles.width[0]:
        yield ("gas", "jet", "slot"), f"is not a piece of the floor from 0 on; see {see('particles.width')}"


def jet_is_told_apart(gas: g.GasFlow, heat: g.GasHeat | None, see: See) -> Mistakes:
    """Refuse a jet of another temperature where no energy equation is solved."""
    if gas.jet is not None and heat is None and gas.jet.T != gas.T:
        yield ("gas", "jet", "T"), f"differs from the gas, {see('gas.T')}, without a [heat] table"


def times_are_in_order(time: g.GasTime, see: See) -> Mistakes:
    """Require at least one sample between the start of the averages and the end of the run."""
    if time.average_from >= time.end:
        yield ("time", "average_from"), f"is not before the end; see {see('time.end')}"
    if time.sample > time.end - time.average_from:
        yield ("time", "sample"), f"no sample between average_from and end; see {see('time.end')}"


def closure_is_of_a_fixed_bed(closure: g.NusseltClosure | None, particles: g.GasParticles, see: See) -> Mistakes:
    """Refuse to fit a Nusselt number to particles that move."""
    if closure is not None and not particles.fixed:
        yield ("closure",), f"a Nusselt number is fitted to a bed at rest; set {see('particles.fixed')} = true"


def file_can_be_used(particles: g.GasParticles, gas: g.GasFlow, origin: Origin) -> Mistakes:
    """Read the file and set up its particles as for a run, so that both say the same."""
    if particles.file is None or particles.count is not None or "\0" in particles.file:
        return
    path = origin.base / particles.file
    if not path.is_file() or (particles.radius is None and not is_dump(path)):
        return
    from contbed.cfd_dem.plan import read, require_room, simulation_of

    found = read(particles, origin.base)
    require_room(particles, gas, found, origin)
    try:
        simulation_of(particles, gas, found)
    except SceneError as error:
        yield ("particles", "file"), str(error)


CHECKS = (
    one_source,
    fluid_is_complete,
    closures_exist,
    jet_is_in_the_floor,
    jet_is_told_apart,
    times_are_in_order,
    closure_is_of_a_fixed_bed,
    file_can_be_used,
)
