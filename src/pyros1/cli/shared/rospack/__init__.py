"""What the verbs of ``pkg`` and ``stack`` share: rospack and rosstack."""
