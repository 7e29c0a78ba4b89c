"""Catalogues of cells, batteries, motors, propellers and MPPTs, with a source of every number.

The files are in ``sizing/data/catalogues``; users write entries of their own as small YAML files.
"""
