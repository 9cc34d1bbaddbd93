"""Balances of a bubbling bed: heat of species and gases, composition, freeboard, steam in tubes."""
