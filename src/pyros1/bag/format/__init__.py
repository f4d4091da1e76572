"""Bag files as bytes: records, chunks, indexes; reading, writing, damaged files."""
