"""A scene: its settings, how a TOML file becomes them, and everything that can be wrong with it."""
