"""Which topics a site sends and receives, and how."""
