"""Tables of encounters: misses, their weight, and the time left."""
