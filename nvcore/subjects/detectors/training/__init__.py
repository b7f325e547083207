"""Training on users' data: recordings with truth, folders of crops and of background."""
