"""Small reacting beds for the tests."""

from copy import deepcopy

from bubbling_scenes import changed

from contbed.bubbling_bed.chemistry import reactions as cr
from contbed.bubbling_bed.chemistry import thermo
from contbed.chemistry.kinetics import reactions_of
from contbed.chemistry.species import Species
from contbed.loading import from_dict
from contbed.scene.reactions import Reaction
from tests.scene_text import scene_of

COAL = {
    "moisture": 0.08,
    "ash": 0.10,
    "volatile_matter": 0.38,
    "ultimate": {"C": 0.70, "H": 0.047, "O": 0.12, "N": 0.013, "S": 0.02},
}
BURNING = {
    name: {}
    for name in (
        "char_combustion",
        "CO_oxidation",
        "H2_oxidation",
        "CH4_oxidation",
        "tar_oxidation",
        "H2S_oxidation",
    )
}
BURNING |= {"drying": {"time": 10.0}, "devolatilisation": {"time": 20.0}}


def particles(share, diameter, density, **keys):
    """One solid phase with its own numbers."""
    return {
        "volume_share": share,
        "diameter": diameter,
        "density": density,
        "heat_capacity": 1000.0,
        "gas_coefficient": 150.0,
        "mixing_conductivity": 4e4 * share + 200.0,
    } | keys


def fed(mass_flow):
    """A cold feed of the lower half."""
    return {"mass_flow": mass_flow, "temperature": 300.0, "height": 0.2, "width": 0.1}


def tables(stone=False, **changes):
    """A combustor of 1 m2 with 1 MW of coal; None removes a table."""
    inert = 0.98 - (0.1 if stone else 0.0)
    coal = {"fuel": deepcopy(COAL), "feed": fed(0.035)}
    found = scene_of(
        """
        gas = { composition = "O2:0.21, N2:0.78, H2O:0.01" }
        mesh = { cells = 12 }
        solver = { degree = 2 }
        output = { plots = false, fields = false }

        [bubbling_bed]
        height = 1.0
        section = 1.0
        solids_fraction = 0.55
        bubbles = { size = 0.1 }
        drain = { time = 7200.0 }
        tubes = { perimeter = 2.0, coefficient = 250.0, temperature = 550.0 }

        [boundary]
        bottom = { gas = { mass_flow = 0.45, temperature = 400.0 } }
    """,
        {
            "solids.char": particles(
                0.02, 2e-3, 900.0, exchange={"inert": 2e4}, **coal
            ),
            "solids.inert": particles(inert, 8e-4, 2600.0),
            "reactions": deepcopy(BURNING),
        },
    )
    if stone:
        lime = {"limestone": {"purity": 0.95}, "feed": fed(0.005)}
        found["solids"]["stone"] = particles(
            0.1, 6e-4, 2600.0, exchange={"inert": 1e5}, **lime
        )
        found["reactions"] |= {"calcination": {}, "sulphation": {}}
    return changed(found, changes)


def without_fuel(**changes):
    """The tables of a combustor of coal without the coal, whose particles stay."""
    found = tables(**changes)
    for key in ("fuel", "feed"):
        found["solids"]["char"].pop(key)
    return found


def combustor(stone=False, **changes):
    """Its scene."""
    return from_dict(tables(stone, **changes))


def tube(composition, reactions, freeboard=None, **changes):
    """Gas alone through a bed without bubbles that its walls hold at 1200 K."""
    found = scene_of(
        f"""
        [bubbling_bed]
        height = 0.5
        section = 0.1
        solids_fraction = 0.55
        walls.perimeter = 1.0
        walls.coefficient = 1e6
        walls.temperature = 1200.0

        [gas]
        composition = {composition!r}

        [boundary.bottom.gas]
        mass_flow = 0.02
        temperature = 1200.0

        [solids]

        [mesh]
        cells = 20

        [solver]
        degree = 3

        [initial]
        temperature = 1200.0

        [output]
        plots = false
        fields = false
    """,
        {
            "reactions": reactions,
            "solids.inert": particles(1.0, 2e-3, 2600.0, gas_coefficient=1e4),
        },
    )
    if freeboard is not None:
        found["bubbling_bed"]["freeboard"] = freeboard
    return from_dict(changed(found, changes))


def of_gases(name, factor=1.0, mixing=0.0):
    """A reaction of gases with its first law, as a bubbling bed has it."""
    table = Reaction(factor=factor)
    species = Species({each: thermo.table()[each] for each in thermo.GASES}, {})
    (reaction,) = reactions_of(name, table, species)
    return cr.OfGases(reaction, mixing, 0.45)
