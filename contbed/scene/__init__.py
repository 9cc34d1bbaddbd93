"""The scene: its settings, how a TOML file is read into them, and the checks of its
values.
"""
