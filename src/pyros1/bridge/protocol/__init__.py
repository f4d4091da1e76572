"""The protocol between sites: packets, their keys, and versioned lists. No I/O."""
