"""Experiments with people: what they share, and one folder for each kind.

`store`: a file that keeps every answer at once. `participants`: who takes part, under which name.
`order`: orders that are balanced over them. `ratings`: how annoying are clips? `detectability`:
would a driver have seen this pedestrian?
"""
