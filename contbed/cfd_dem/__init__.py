"""Particles that move in a gas: discrete elements coupled to a gas on a grid."""
