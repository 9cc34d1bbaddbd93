"""The cases of the peer: sizes, materials and starts."""

from __future__ import annotations

from dataclasses import dataclass

SOLVER = "twoPhaseEulerFoam"
GASES = {"settling": {"rho": 998.0, "mu": 1e-3}, "riemann": {"rho": 1.0, "mu": 1e-6}}
AIR = {"rho": 1.2, "mu": 1.8e-5}
SIZES = {"riser": (0.152, 7.9), "bed": (0.28, 1.0)}  # width and height [m]
COLUMNS = {"settling": 0.1, "riemann": 1.0}  # height [m]; cells are square
# height of the lower part [m], fractions of solids below and above
STARTS = {
    "bed": (0.40, 0.60, 0.0),
    "settling": (1.0, 0.1, 0.0),
    "riemann": (0.5, 0.02, 0.01),
}
# d p_solid/d eps_s = g0 min(exp(preAlphaExp (eps_s - alphaMax)), expMax) [Pa]
STIFFNESS = {"settling": (10.0, 500, 1000), "riemann": (2500.0, 0, 1)}


@dataclass(frozen=True)
class Case:
    """One case. `walls` of the solids: "jj", "noslip" or "slip"; no Courant number
    means the fixed step `dt`.
    """

    kind: str
    nx: int
    ny: int
    end: float
    gas: float  # superficial velocity [m/s]
    drag: str = "WenYu"
    solids: float = 0.0  # flux over the section of a riser [kg/m2/s]
    courant: float | None = 0.5
    dt: float = 1e-4
    largest_dt: float = 2e-3
    average_from: float = 1e9
    walls: str = "noslip"
    upwind: bool = False
    on_faces: bool = False  # momentum solved for on faces instead of in cells
    # of a riser: eps_s, velocities of gas and solids [m/s]
    start: tuple[float, float, float] | None = None
    write_every: float | None = None  # [s]; without it the last state alone is written

    @property
    def riser(self) -> bool:
        return self.kind == "riser"

    @property
    def column(self) -> bool:
        return self.kind in COLUMNS

    @property
    def size(self) -> tuple[float, float]:
        """Width and height [m]."""
        if self.column:
            return COLUMNS[self.kind] * self.nx / self.ny, COLUMNS[self.kind]
        return SIZES[self.kind]

    @property
    def particles(self) -> dict[str, float]:
        if self.riser:
            return {
                "d": 150e-6,
                "rho": 2550.0,
                "max": 0.60,
                "e": 0.95,
                "e_w": 0.90,
                "specularity": 0.01,
            }
        d, packed = (100e-6, 0.60) if self.column else (275e-6, 0.63)
        return {
            "d": d,
            "rho": 2500.0,
            "max": packed,
            "e": 0.90,
            "e_w": 0.90,
            "specularity": 0.01,
        }


BED_HEIGHT, BED_FRACTION = STARTS["bed"][:2]
# the two inlets of solids in the sides of the riser [m]
SIDE = (4 * 7.9 / 350, 11 * 7.9 / 350)
SIDE_FRACTION = 0.20
