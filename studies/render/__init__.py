"""Results as people read them.

* ``analysis``, ``sizing``, ``uncertainty``, ``weather``: headline and blocks of what the sizing
  layer computes, as modules of studies have for theirs
* ``sentences``: what needs judgement; ``words`` of numbers, requirements and notes
* ``design_sheet``: quantities of a design as a table, for papers, workbooks and reports
* ``tables``: blocks as text, Markdown, HTML, CSV and frames; ``layout`` of their text
"""
