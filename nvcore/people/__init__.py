"""Studies with people: what the subjects that ask people share.

`store`: a file that keeps every answer at once. `participants`: who takes part, under which name.
`form`: what they say about themselves.
"""
