"""Whole solar cells on wing and tail, and their strings."""
