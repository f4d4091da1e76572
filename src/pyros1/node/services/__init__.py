"""Services that a node provides, and clients of services."""
