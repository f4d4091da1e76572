"""Playing bags."""
