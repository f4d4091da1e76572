"""Topics that a node subscribes to: handles, the subscription, its connections, delivery."""
