"""From a plan to running, supervised processes."""
