"""Access control: optional log-in by OpenID Connect, own hosts and origins, local files."""
