"""Writes new bags from old ones."""
