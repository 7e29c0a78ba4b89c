"""Computed against published and independent numbers: scripts that judge the project."""
