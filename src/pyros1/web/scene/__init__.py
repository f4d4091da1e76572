"""The contents of a 3D scene (frames, and messages with their poses), in a form that is easy for a page to draw."""
