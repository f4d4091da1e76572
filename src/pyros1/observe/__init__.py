"""Handling of messages of any type, for tools and views: decoding, field paths, expressions and statistics."""
