"""Views of bags."""
