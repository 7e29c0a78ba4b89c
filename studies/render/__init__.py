"""Results as people read them.

* ``results``: blocks of a result at a level; ``chance`` those of draws and of weather records
* ``sentences``: what needs judgement; ``words`` of requirements, ``numbers`` with their units
* ``tables``: blocks as text, Markdown, HTML, CSV and frames; ``layout`` of their text
"""
