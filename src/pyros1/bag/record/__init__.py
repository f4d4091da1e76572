"""Records topics into bags."""
