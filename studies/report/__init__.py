"""Reports: one page about a design, its mission and what to believe of it."""
