"""Data page: names and facts of systems and recordings, changed after they were opened."""
