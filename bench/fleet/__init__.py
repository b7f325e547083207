"""The fleet at size: a generator, what each step costs, and what that means at 10^11 frames."""
