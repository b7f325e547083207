"""What every page has: sidebar, navigation, messages."""
