"""Pages in headless Chromium: how fast the explorer answers, and pictures for the documentation.

Needs Chromium and ``pip install ".[browser]"``.
"""
