"""Sizing layer: aircraft, their day and night energy balance, and their optimisation.

Built on :mod:`missions` and :mod:`solar`.
"""
