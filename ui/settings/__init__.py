"""Settings of the server: the session that it opens, and limits for visitors."""
