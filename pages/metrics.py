"""Metrics: what every measure means, what the report's files hold, which formats are read."""

from ui.documentation import page

page.draw()
