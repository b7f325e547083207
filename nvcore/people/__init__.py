"""Studies with people: what the subjects that ask people share.

`store`: a file that keeps every answer at once. `participants`: who takes part, under which name.
`order`: orders that are balanced over them. `terms`: what participants are promised.
"""
