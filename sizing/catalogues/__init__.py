"""Catalogues of cells, batteries, motors and propellers, with a source of every number.

The files are in ``sizing/data/catalogues``; users write entries of their own as small YAML files.
"""
