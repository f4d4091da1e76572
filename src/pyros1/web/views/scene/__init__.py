"""Views of the 3D scene."""
