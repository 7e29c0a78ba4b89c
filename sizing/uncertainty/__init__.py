"""Uncertain inputs: what they are, and what they make of a flight."""
