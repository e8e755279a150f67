"""Report kit: self-contained HTML pages that open offline, static pictures and number text; knows no domain.

A report is a sequence of sections (`base.AbstractSection`), one module each in the room of its subject, e.g.
`flexros.analysis.report`. Each returns blocks (`base`): paragraphs, tiles, tables, pictures, and what is folded away.
`page.page_html` assembles them to one page, with the style sheet and scripts of `style`.

* `theme`, `grid`: interactive pictures (plotly) in a common style; `decimate` reduces series to screen resolution.
* `drawing`: static SVG pictures for pages of results.
* `colours`: colours with a meaning, and those of a dark page; `entries`: nested entries as rows of a table.
* `number_text`: numbers and shares as text, for reports, terminal and messages.
"""
