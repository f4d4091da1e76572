"""Messages of several topics that belong together, and those of a while ago (https://wiki.ros.org/message_filters)."""
