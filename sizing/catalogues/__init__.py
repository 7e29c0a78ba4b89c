"""Catalogues of solar cells, batteries and motors that can be had, with a source of every number.

The files are in ``sizing/data/catalogues``; users write entries of their own as small YAML files.
"""
