"""Closures: published correlations as pure functions with their range, unit and source as data.

Use one from a script, on numbers or arrays of any shape that broadcasts:

    >>> import numpy as np
    >>> from contbed import closures
    >>> Re = np.array([50.0, 400.0])
    >>> closures.nusselt_wakao_kaguei(Re=Re, Pr=0.7).round(3)
    array([12.213, 37.563])

Or by name, as a scene does, and ask what was used outside of the declared range (bounds are inclusive):

    >>> nusselt = closures.get("nusselt_gunn", kind="nusselt")
    >>> use = closures.usage(nusselt, Re=Re, Pr=0.7, eps=np.array([0.3, 0.4]))
    >>> use.arguments["eps"]
    ArgumentUse(declared=(0.35, 1.0), used=(0.3, 0.4), share_outside=0.5)

`closures.names(kind)` lists them and `print(closures.data_sheet(name))` shows one. Kinds: nusselt [-],
conductivity [W/m/K], tortuosity [-], dispersion [W/m/K], permeability [m2], forchheimer [-],
pressure_gradient [Pa/m], radiation [W/m/K or -], wall [W/m2/K]; of fluidized beds
minimum_fluidization [-], drag [kg/m3/s], bubble_size [m], bubble_rise [m/s], gas_exchange [1/s],
bubble_heat [W/m3/K]; of granular flow radial_distribution, granular_pressure, granular_viscosity,
granular_bulk_viscosity, granular_conductivity, granular_dissipation, without units, granular_friction [Pa]
and granular_friction_viscosity [Pa s].
"""

from contbed.closures.bed_tube import (
    bed_tube_martin,
    bed_tube_molerus_laminar,
    bed_tube_molerus_wirth,
    bed_tube_zabrodsky,
)
from contbed.closures.bubble_size import (
    bubble_growth_darton,
    bubble_growth_horio_nonaka,
    bubble_growth_mori_wen,
    bubble_size_mori_wen,
    bubble_start_darton,
    bubble_start_orifices,
    bubble_start_porous_plate,
)
from contbed.closures.bubbles import (
    bubble_heat_kunii_levenspiel,
    bubble_heat_sit_grace,
    bubble_rise_davidson_harrison,
    gas_exchange_kunii_levenspiel,
    gas_exchange_sit_grace,
)
from contbed.closures.conductivity import conductivity_hsu, conductivity_krupiczka, tortuosity_hsu
from contbed.closures.conductivity_bounds import (
    conductivity_hashin_shtrikman_lower,
    conductivity_hashin_shtrikman_upper,
    conductivity_maxwell,
    conductivity_parallel,
    conductivity_series,
)
from contbed.closures.conductivity_cell import (
    conductivity_kunii_smith,
    conductivity_zehner_bauer_schluender,
    conductivity_zehner_schluender,
)
from contbed.closures.dispersion import (
    DispersionPair,
    dispersion_pair,
    dispersion_vdi_axial,
    dispersion_vdi_transverse,
    dispersion_wakao_kaguei_axial,
    dispersion_wakao_kaguei_transverse,
)
from contbed.closures.drag import drag_di_felice, drag_gidaspow, drag_syamlal_obrien, drag_wen_yu
from contbed.closures.fluidization import (
    bubble_fraction_kunii_levenspiel,
    bubble_fraction_two_phase,
    emulsion_gas_kunii_levenspiel,
    emulsion_gas_two_phase,
    expansion_souza_santos,
    nusselt_kunii_levenspiel,
    solids_mixing_kunii_levenspiel,
)
from contbed.closures.freeboard import (
    decay_kunii_levenspiel,
    ejection_pemberton_davidson,
    ejection_wen_chen,
    elutriation_colakyan_levenspiel,
    elutriation_geldart,
    terminal_velocity_haider_levenspiel,
)
from contbed.closures.granular import (
    g0_carnahan_starling,
    g0_lun_savage,
    g0_ma_ahmadi,
    g0_sinclair_jackson,
    granular_pressure_dilute,
    granular_pressure_lun,
    granular_pressure_syamlal,
)
from contbed.closures.granular_friction import (
    friction_johnson_jackson,
    friction_viscosity_newtonian,
    friction_viscosity_schaeffer,
)
from contbed.closures.granular_transport import (
    granular_bulk_lun,
    granular_conductivity_gidaspow,
    granular_conductivity_syamlal,
    granular_dissipation_lun,
    granular_viscosity_gidaspow,
    granular_viscosity_syamlal,
)
from contbed.closures.minimum_fluidization import (
    minimum_fluidization_babu,
    minimum_fluidization_chitester,
    minimum_fluidization_ergun,
    minimum_fluidization_grace,
    minimum_fluidization_richardson,
    minimum_fluidization_saxena_vogel,
    minimum_fluidization_wen_yu,
)
from contbed.closures.nusselt import (
    nusselt_gunn,
    nusselt_kuwahara,
    nusselt_kuwahara_pivem,
    nusselt_power,
    nusselt_ranz_marshall,
    nusselt_wakao_kaguei,
)
from contbed.closures.optics import radiation_emissivity_half_space, radiation_rosseland
from contbed.closures.pressure_drop import (
    forchheimer_ergun,
    forchheimer_ward,
    permeability_carman_kozeny,
    permeability_ergun,
    permeability_kuwahara,
    permeability_pivem,
    pressure_gradient_ergun,
)
from contbed.closures.registry import RangeUse, Sheet, closure, data_sheet, get, names, sheet, usage
from contbed.closures.solid_solid import solid_exchange_agu
from contbed.closures.wall import wall_li_finlayson, wall_martin_nilles

__all__ = [
    "DispersionPair",
    "RangeUse",
    "Sheet",
    "bed_tube_martin",
    "bed_tube_molerus_laminar",
    "bed_tube_molerus_wirth",
    "bed_tube_zabrodsky",
    "bubble_fraction_kunii_levenspiel",
    "bubble_fraction_two_phase",
    "bubble_growth_darton",
    "bubble_growth_horio_nonaka",
    "bubble_growth_mori_wen",
    "bubble_heat_kunii_levenspiel",
    "bubble_heat_sit_grace",
    "bubble_rise_davidson_harrison",
    "bubble_size_mori_wen",
    "bubble_start_darton",
    "bubble_start_orifices",
    "bubble_start_porous_plate",
    "closure",
    "conductivity_hashin_shtrikman_lower",
    "conductivity_hashin_shtrikman_upper",
    "conductivity_hsu",
    "conductivity_krupiczka",
    "conductivity_kunii_smith",
    "conductivity_maxwell",
    "conductivity_parallel",
    "conductivity_series",
    "conductivity_zehner_bauer_schluender",
    "conductivity_zehner_schluender",
    "data_sheet",
    "decay_kunii_levenspiel",
    "dispersion_pair",
    "dispersion_vdi_axial",
    "dispersion_vdi_transverse",
    "dispersion_wakao_kaguei_axial",
    "dispersion_wakao_kaguei_transverse",
    "drag_di_felice",
    "drag_gidaspow",
    "drag_syamlal_obrien",
    "drag_wen_yu",
    "ejection_pemberton_davidson",
    "ejection_wen_chen",
    "elutriation_colakyan_levenspiel",
    "elutriation_geldart",
    "emulsion_gas_kunii_levenspiel",
    "emulsion_gas_two_phase",
    "expansion_souza_santos",
    "forchheimer_ergun",
    "forchheimer_ward",
    "friction_johnson_jackson",
    "friction_viscosity_newtonian",
    "friction_viscosity_schaeffer",
    "g0_carnahan_starling",
    "g0_lun_savage",
    "g0_ma_ahmadi",
    "g0_sinclair_jackson",
    "gas_exchange_kunii_levenspiel",
    "gas_exchange_sit_grace",
    "get",
    "granular_bulk_lun",
    "granular_conductivity_gidaspow",
    "granular_conductivity_syamlal",
    "granular_dissipation_lun",
    "granular_pressure_dilute",
    "granular_pressure_lun",
    "granular_pressure_syamlal",
    "granular_viscosity_gidaspow",
    "granular_viscosity_syamlal",
    "minimum_fluidization_babu",
    "minimum_fluidization_chitester",
    "minimum_fluidization_ergun",
    "minimum_fluidization_grace",
    "minimum_fluidization_richardson",
    "minimum_fluidization_saxena_vogel",
    "minimum_fluidization_wen_yu",
    "names",
    "nusselt_gunn",
    "nusselt_kunii_levenspiel",
    "nusselt_kuwahara",
    "nusselt_kuwahara_pivem",
    "nusselt_power",
    "nusselt_ranz_marshall",
    "nusselt_wakao_kaguei",
    "permeability_carman_kozeny",
    "permeability_ergun",
    "permeability_kuwahara",
    "permeability_pivem",
    "pressure_gradient_ergun",
    "radiation_emissivity_half_space",
    "radiation_rosseland",
    "sheet",
    "solid_exchange_agu",
    "solids_mixing_kunii_levenspiel",
    "terminal_velocity_haider_levenspiel",
    "tortuosity_hsu",
    "usage",
    "wall_li_finlayson",
    "wall_martin_nilles",
]
