"""Who may open the app: log-in by OpenID Connect where it is set up, own hosts and origins."""
