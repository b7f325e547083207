"""Parts common to all pages: sidebar, navigation, messages."""
