"""Study page: ask people in the browser whether they would have seen a pedestrian."""
