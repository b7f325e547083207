"""Files that a session names: found, unpacked, hashed, read from pipes."""
