"""Parts of the Encounters page."""
