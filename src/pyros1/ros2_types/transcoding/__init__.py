"""Converts encoded messages from one side to the other, by functions that are generated for each pair of types."""
