"""Data page: findings of the audit, and the cases of each finding."""
