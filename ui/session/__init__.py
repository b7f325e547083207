"""What one browser session has open: workspace, uploads, routes, address."""
