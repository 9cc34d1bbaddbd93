"""Closures: published correlations as pure functions with their range, unit and source as data.

Use one from a script, on numbers or arrays of any shape that broadcasts:

    >>> import numpy as np
    >>> from contbed import closures
    >>> Re = np.array([50.0, 400.0])
    >>> closures.nusselt_wakao_kaguei(Re=Re, Pr=0.7).round(3)
    array([12.213, 37.561])

Or by name, as a scene does, and ask what was used outside of the declared range (bounds are inclusive):

    >>> nusselt = closures.get("nusselt_gunn", kind="nusselt")
    >>> use = closures.usage(nusselt, Re=Re, Pr=0.7, eps=np.array([0.3, 0.4]))
    >>> use.arguments["eps"]
    ArgumentUse(declared=(0.35, 1.0), used=(0.3, 0.4), share_outside=0.5)

`closures.names(kind)` lists them and `print(closures.data_sheet(name))` shows one. Kinds: nusselt [-],
conductivity [W/m/K], tortuosity [-], dispersion [W/m/K], permeability [m2], forchheimer [-],
pressure_gradient [Pa/m], wall [W/m2/K].
"""
