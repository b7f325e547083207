"""The Study page: would a driver have seen this pedestrian? Asked of people, in the browser."""
