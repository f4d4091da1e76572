"""The contents of a 3D scene: frames, and messages with their poses, in a form that a page can easily draw."""
