"""What the verbs of ``bag`` share that write files."""
