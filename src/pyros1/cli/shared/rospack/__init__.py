"""What the verbs of ``pkg`` and ``stack`` share, as rospack and rosstack."""
