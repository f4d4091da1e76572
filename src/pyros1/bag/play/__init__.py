"""Plays bags."""
