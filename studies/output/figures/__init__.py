"""What all figures share: size, resolution and style; how they begin, what they fit, their files.

* ``options``: :class:`~studies.output.figures.options.FigureOptions`, as asked for
* ``drawing``: begins every figure, in its style; palette, headings, files
* ``styles``: shipped styles
"""
