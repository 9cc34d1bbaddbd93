"""Equations of a reacting bed: gas, solid phases, intraparticle gas, the section
across the flow.
"""
