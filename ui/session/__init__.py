"""State of one browser session: workspace, uploads, routes, page address."""
