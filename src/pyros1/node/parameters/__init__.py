"""A node's parameters: those on the master, their local copies, and private ones from the command line."""
