"""Measured quantities of a flight with a model of each: solar power, load, charge."""
