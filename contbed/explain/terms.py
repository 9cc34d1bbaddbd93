"""Terms of the field that scenes and results use, for `contbed explain` and the
glossary of the manual.
"""

from __future__ import annotations

TERMS = {
    "Geldart": (
        "Groups of powders by their behaviour when air fluidizes them. A: aeratable, "
        "expands before it bubbles, "
        "30 to 100 um and light; B: sand-like, bubbles at once, 40 to 500 um; C: "
        "cohesive, finer than 30 um; D: "
        "spoutable, coarser than 600 um or dense. A and B part near (rho_s - rho_g) "
        "d_p = 225 kg/m3 um, B and D near "
        "(rho_s - rho_g) d_p^2 = 1e6 kg/m3 um^2. Geldart 1973, Powder Technol. 7, "
        "285-292, "
        "doi:10.1016/0032-5910(73)80037-3. contbed does not choose a model by the "
        "group."
    ),
    "excess air": "Air beyond that which burns the fuel, over it: oxygen_ratio - 1.",
    "burnt share": "Share of the fuel's heating value that is released: "
    "combustion_efficiency.",
    "round-trip efficiency": "Heat that a store gives back over what it has taken up: "
    "storage_efficiency; by exergy exergy_efficiency.",
    "breakthrough": "Time at which a gas leaves a column at 1, 5, 50 or 95 % of the mole "
    "fraction that enters: breakthrough_5_CO2_s.",
    "phase change material": "Solid that melts over a range of temperature and takes up "
    "its latent heat there: solids.NAME.melting.",
    "humidity ratio": "Mass of water vapour over that of the dry air it is in.",
    "superficial velocity": "Volume flow over the cross-section of the bed; that in "
    "the pores is 1/eps of it.",
    "intrinsic": "Averaged over the volume of one phase alone, not over that of the "
    "bed.",
    "two-energy": "Model with a temperature for the fluid and one for the solid, local "
    "thermal non-equilibrium (LTNE).",
    "Danckwerts": (
        "Condition of an inlet: what a stream carries is given, not the temperature at "
        "the entrance, which conduction "
        "in the bed may raise. `inflow` in a scene."
    ),
    "Robin": "Condition of a wall: the heat flux is a coefficient times the difference "
    "to an ambient temperature.",
    "SUPG": "Streamline-upwind Petrov-Galerkin: stabilises convection in proportion to "
    "the residual.",
    "manufactured solution": "Chosen field whose source term is put into the "
    "equations: its error is known exactly.",
    "Sauter mean": "Diameter of the sphere with the ratio of volume to surface of all "
    "particles together, d_32.",
    "emulsion": "Part of a bubbling bed outside of the bubbles: particles with gas at "
    "about minimum fluidization.",
    "freeboard": "Room above the surface of a fluidized bed, into which bubbles throw "
    "particles.",
    "minimum fluidization": "State in which the drag of the gas just carries the "
    "weight of the bed.",
    "granular temperature": "Third of the mean square of the fluctuation of the "
    "particles' velocities [m2/s2].",
    "coordination number": "Number of neighbours that a particle touches.",
    "albedo": "Scattered share of the extinction of radiation.",
    "optical thickness": "Extinction coefficient times the length of the path.",
    "qoi": "Named result of a run, a quantity of interest: one number with a unit, in "
    "`summary.json` under this key.",
    "closure": "Published correlation that a balance needs to be closed, such as a "
    "Nusselt number.",
    "range": "Values of arguments on which a closure was fitted; a run reports the "
    "share of points outside.",
}
"""Meaning of each term."""
