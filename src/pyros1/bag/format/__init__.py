"""The bag file format: records, chunks and indexes, readers and writer, damaged and old files."""
