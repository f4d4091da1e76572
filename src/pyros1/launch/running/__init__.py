"""A plan to running, supervised processes."""
