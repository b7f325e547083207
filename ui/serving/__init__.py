"""The server around the pages: start and shutdown, log-in gate, headers, and visitor limits."""
