"""Explorer: a local page whose sliders show at once what a design choice does."""
