"""Whole cells: solar cells laid on wing and tail, and their strings."""
