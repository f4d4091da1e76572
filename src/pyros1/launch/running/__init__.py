"""Runs a plan as supervised processes."""
