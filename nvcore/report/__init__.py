"""What is handed on: verdict, terminal scorecard, CSV files, gate."""
