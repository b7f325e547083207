"""What the program writes: text of CSV files, and files that are whole or not there."""
