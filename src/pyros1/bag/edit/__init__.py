"""Writes new bags from existing ones."""
