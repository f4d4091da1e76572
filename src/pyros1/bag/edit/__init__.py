"""New bags from old ones."""
