"""Studies with people: what the pages that ask people share, below them and above the widgets."""
