"""Views of the scene in 3D."""
