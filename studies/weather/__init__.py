"""Figures of weather records that are flown through."""
