"""Tools that make what ships, and do not ship themselves; run from the project's folder."""
