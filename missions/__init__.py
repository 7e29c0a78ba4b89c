"""Mission layer: where, when and in which air an aircraft flies, and the mission library.

Built on :mod:`solar` only.
"""
