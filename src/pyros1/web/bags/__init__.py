"""Bags on a page: access to files, their contents, playback and recording."""
