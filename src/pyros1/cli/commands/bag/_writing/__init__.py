"""Shared code of the verbs of ``bag`` that write files."""
