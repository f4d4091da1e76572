"""Topics that a node subscribes to: handles, subscriptions, their connections and delivery."""
