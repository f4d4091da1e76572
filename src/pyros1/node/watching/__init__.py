"""Watching other nodes: word of those that die, hang, are replaced or come back."""
