"""Watching other nodes: notification of nodes that die, hang, are replaced or come back."""
