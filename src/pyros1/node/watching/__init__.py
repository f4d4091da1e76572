"""Watches other nodes, and notifies the program when they die, hang, are replaced or come back."""
