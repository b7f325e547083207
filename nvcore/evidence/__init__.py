"""More than chance? Units, intervals, paired tests, groups."""
