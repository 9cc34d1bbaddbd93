"""Calibration: keys of scenes fitted to measured values, with what the data tell about them and what they predict."""
