"""Results as people read them.

* ``results``: blocks of any result at a level; ``analysis``, ``sizing``, ``uncertainty`` and
  ``weather`` have those of the sizing layer, with ``parts`` and ``sizing_tables``
* ``sentences``: what needs judgement; ``words`` of requirements, ``numbers`` with their units
* ``design_sheet``: quantities of a design as a table, for papers, workbooks and reports
* ``tables``: blocks as text, Markdown, HTML, CSV and frames; ``layout`` of their text
"""
