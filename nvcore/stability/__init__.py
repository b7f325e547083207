"""Maps of the verdict over the settings: does it depend on them."""
