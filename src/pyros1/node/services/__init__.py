"""Services that a node provides and calls."""
