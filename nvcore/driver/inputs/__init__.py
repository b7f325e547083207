"""From a file of estimates to the detectability of the truth's boxes."""
