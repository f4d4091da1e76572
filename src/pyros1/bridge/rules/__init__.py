"""The rules of a site: which topics it sends and receives, and how."""
