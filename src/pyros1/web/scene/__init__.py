"""What a 3D scene shows: frames, and messages with their places, in a form that a page draws without much work."""
