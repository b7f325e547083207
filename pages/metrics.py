"""Metrics page: meaning of every measure, columns of the report's files, and input formats."""

from ui.views.documentation import page

page.draw()
