"""Status output and snapshots of ``bag record`` and ``bag play``."""
