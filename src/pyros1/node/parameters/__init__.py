"""A node's parameters: those on the master and their local copies, and private ones of the command line."""
