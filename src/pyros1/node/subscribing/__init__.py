"""The topics that a node subscribes to: subscribers, subscriptions, their links and delivery."""
