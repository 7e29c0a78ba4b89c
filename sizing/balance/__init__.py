"""Balance of an aircraft: planform, tails, drag by components, centre of gravity, trim.

Records of the aircraft's file and formulas; equations and sources: docs/balance.md.
"""
