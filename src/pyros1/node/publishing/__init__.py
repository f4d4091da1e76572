"""Topics that a node publishes: handles, the publication, its links."""
