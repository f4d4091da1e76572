"""Shared code of ``bag record`` and ``bag play`` for status output, and the snapshots of ``bag record``."""
