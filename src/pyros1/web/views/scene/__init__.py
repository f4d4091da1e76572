"""Views for the 3D scene: frames, messages, cameras, depth images and interactive markers."""
