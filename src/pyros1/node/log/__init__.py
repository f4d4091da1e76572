"""A node's log: loggers, where it goes, /rosout and the services that set its levels."""
