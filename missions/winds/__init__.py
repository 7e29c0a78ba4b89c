"""Winds that change with latitude, altitude and month: tables of their percentiles."""
