"""A bridge that speaks as zenoh-plugin-ros1 does, so that robots which run its zenoh-bridge-ros1 need no change."""
