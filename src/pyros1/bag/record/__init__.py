"""Recording topics into bags."""
