"""Comparison of solar power models: predictions for an aircraft, and designs sized with each.

* ``comparison``: ``compare``: predictions, seasons and designs by model and correction
* ``prediction``: what a model says of an aircraft; ``solar_models``: which models there are
* ``component_efficiencies``: what drives the Full Model; ``report_reproduction``: published powers
"""
