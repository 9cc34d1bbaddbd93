"""Equations of a reacting bed: gas, solid phases, the inside of particles, the section across the flow."""
