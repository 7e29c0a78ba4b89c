"""Catalogues of cells, batteries, motors, propellers and MPPTs, with a source of every number.

The files are in ``sizing/data/catalogues``; users write user-defined entries as small YAML files.
"""
