"""Heat of the two-fluid model: temperatures of gas and particles on the mass fluxes
of the flow.
"""
