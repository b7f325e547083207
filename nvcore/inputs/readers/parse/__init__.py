"""Parse text, JSON and XML to rows, with file and line in every error."""
