"""Bags on a page: which files may be opened, what is in them, and playing and recording."""
