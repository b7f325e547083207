"""Scripts for developers of the project. Run them from its root folder."""
