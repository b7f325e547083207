"""Estimators of what the driver sees: errors, pairs of features, detectability by period."""
