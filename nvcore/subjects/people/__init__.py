"""Studies with people: one engine for every task that participants may be given.

`store` keeps studies, participants and answers, and explains how to add a task. `participants` has
names, codes and orders, `form` the terms and what participants say about themselves.
"""
