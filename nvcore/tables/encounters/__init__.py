"""Tables of encounters: what is missed of each, how it weighs, and what time was left."""
