"""Contents of a 3D scene: frames, and messages with their poses, in a form that is easy to draw for a page."""
