"""A node's parameters: those on the master, their local copies, and private parameters from the command line."""
