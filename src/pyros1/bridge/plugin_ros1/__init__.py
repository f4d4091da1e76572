"""A bridge with the protocol of zenoh-plugin-ros1, for robots that run its zenoh-bridge-ros1."""
