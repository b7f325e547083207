"""Reading of detectability estimates and their assignment to truth boxes."""
