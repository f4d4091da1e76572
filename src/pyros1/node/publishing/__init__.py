"""Topics that a node publishes: handles, publications and their links."""
