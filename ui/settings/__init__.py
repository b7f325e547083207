"""How the server was started: what it opens, and how much it lets visitors take."""
