"""What ``bag record`` and ``bag play`` do while they run."""
