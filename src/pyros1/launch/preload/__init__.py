"""Python nodes as forks of processes that have imported pyros1 already."""
