"""A node's log: loggers, their sink, /rosout and the services that set its levels."""
