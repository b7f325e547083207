"""Training on what users have: recordings with truth, folders of crops and of background."""
