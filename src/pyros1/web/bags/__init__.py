"""Bags on a page: finding and reading bag files, playing and recording."""
