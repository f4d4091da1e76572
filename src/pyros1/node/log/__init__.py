"""A node's log: its loggers and their sink, /rosout, and the services that set log levels."""
