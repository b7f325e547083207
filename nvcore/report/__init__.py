"""Outputs of a comparison: verdict, terminal scorecard, CSV files, HTML report, gate."""
