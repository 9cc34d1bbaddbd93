"""Rate laws that scenes name: which there are, what they need, and the equations
that belong to them.
"""

from __future__ import annotations

from contbed.chemistry.equation import Equation
from contbed.chemistry.laws_of_gases import LAWS
from contbed.chemistry.reforming import REACTIONS as REFORMING
from contbed.chemistry.three_interfaces import TAKAHASHI
from contbed.errors import SceneError
from contbed.scene.reactions import Reaction

# three steps, per mole of the reducing gas
_STAGES = (
    "{0} + 3 Fe2O3 -> 2 Fe3O4 + {1}",
    "{0} + Fe3O4 -> 3 FeO + {1}",
    "{0} + FeO -> Fe + {1}",
)
STAGED: dict[str, str] = {f"three_interfaces_{gas}": gas for gas in TAKAHASHI}
IRON = ("Fe2O3", "Fe3O4", "FeO", "Fe")
LAWS_WITH_EQUATION: dict[str, str | tuple[str, ...]] = {
    **REFORMING,
    **{
        f"{name}.{law.name}": law.reaction
        for name, laws in LAWS.items()
        for law in laws.values()
    },
    **{
        key: tuple(stage.format(gas, TAKAHASHI[gas].oxidised) for stage in _STAGES)
        for key, gas in STAGED.items()
    },
}
# keys that each law of a scene's own constants needs
NEEDS: dict[str, tuple[str, ...]] = {
    "power": ("A", "E"),
    "grain": ("A", "E", "grain_radius", "molar_density"),
    "grain_remaining": ("A", "E", "grain_radius", "molar_density"),
    "shrinking_core": ("A", "E", "diffusivity"),
}


def known_laws(name: str) -> list[str]:
    """Return the laws that a reaction of this name may have."""
    return [*NEEDS, *REFORMING, *STAGED, *LAWS.get(name, {})]


def equations_of(name: str, reaction: Reaction) -> dict[str, Equation]:
    """Return the equations that a table of a reaction stands for, by name; a law
    with stages has several.
    """
    if reaction.equation is not None:
        return {name: Equation.of(reaction.equation)}
    found = LAWS_WITH_EQUATION.get(reaction.law or "") or LAWS_WITH_EQUATION.get(
        f"{name}.{reaction.law}"
    )
    if found is None:
        raise SceneError("the equation is missing")
    if isinstance(found, str):
        return {name: Equation.of(found)}
    return {f"{name}_{k + 1}": Equation.of(text) for k, text in enumerate(found)}
