"""Studies with people: the page of participants and that of conductors, for every task."""
