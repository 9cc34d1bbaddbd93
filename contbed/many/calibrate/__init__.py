"""Calibration: keys of scenes fitted to measured values, with what the data
determine of them and what they predict.
"""
