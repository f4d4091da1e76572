"""The format of bag files: records, chunks, indexes; readers, the writer, damaged and old files."""
