"""Results by kind of job: the named results of `contbed.fields` in the order in which
engineers of a trade read them.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Job:
    """A kind of job: the scenes that it means, and names of its results."""

    title: str
    scenes: str
    results: tuple[str, ...]


JOBS = (
    Job(
        "Stores of heat",
        "a packed bed at rest with [heat] and [time] whose fluid enters at a given "
        "temperature, with or without time.cycle; not where fronts are tracked",
        (
            "heat_charged_J",
            "heat_discharged_J",
            "heat_lost_J",
            "heat_lost_at_rest_J",
            "heat_stored_J",
            "storage_capacity_J",
            "utilisation",
            "storage_efficiency",
            "effectiveness_charge",
            "effectiveness_discharge",
            "exergy_charged_J",
            "exergy_discharged_J",
            "exergy_efficiency",
            "thermocline_m",
        ),
    ),
    Job(
        "Columns of adsorbent",
        "a packed bed with solids.NAME.adsorption and [time]; purity, recovery and "
        "productivity with time.cycle, the others without",
        (
            "breakthrough_NAME_s",
            "mass_transfer_zone_NAME_m",
            "capacity_used_NAME",
            "purity_NAME",
            "recovery_NAME",
            "productivity_NAME_mol_kgs",
        ),
    ),
    Job(
        "Reactors",
        "a packed bed with [reactions]; selectivity, yield and space-time yield of "
        "steady states",
        (
            "conversion_NAME",
            "selectivity_NAME",
            "yield_NAME",
            "space_time_yield_NAME_mol_m3s",
            "GHSV_1_h",
            "WHSV_1_h",
            "Q_over_K_NAME",
            "equilibrium_approach_NAME_K",
            "hot_spot_K",
            "hot_spot_m",
        ),
    ),
    Job(
        "Heaters and coolers",
        "a packed bed whose particles move, in a steady state",
        (
            "duty_W",
            "effectiveness",
            "NTU",
            "pinch_K",
            "pinch_m",
            "equilibrium_length_m",
        ),
    ),
    Job(
        "Boilers",
        "a bubbling bed with fuel; efficiency, losses and emissions with air enough to "
        "burn it",
        (
            "fuel_power_W",
            "combustion_efficiency",
            "carbon_conversion",
            "oxygen_ratio",
            "NAME_convection_W",
            "NAME_radiation_W",
            "NAME_water_W",
            "loss_flue_gas",
            "loss_solids",
            "boiler_efficiency",
            "emission_NAME_mg_m3",
        ),
    ),
    Job(
        "Fluidized beds",
        "two fluids in a vessel with an inlet of gas; height, circulation, bubbles and "
        "spectrum with time.average_from",
        (
            "u_mf_m_s",
            "u_over_u_mf",
            "bed_height_m",
            "circulation_kg_m2s",
            "bubbles",
            "bubble_diameter_m",
            "bubble_diameter_max_m",
            "bubble_share",
            "bubble_rise_m_s",
            "dominant_frequency [Hz]",
            "pressure_drop_mean [Pa]",
            "weight_of_solids",
        ),
    ),
)
