"""Figures: tables and results in, Plotly figures out; pure, one module for each figure."""
