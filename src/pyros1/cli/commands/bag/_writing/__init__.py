"""What the verbs of ``bag`` that write files share."""
