"""The topics that a node publishes: publishers, publications and their links."""
