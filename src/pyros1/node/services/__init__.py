"""Services provided by a node, and clients of services."""
