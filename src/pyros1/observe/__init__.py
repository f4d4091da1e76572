"""Functions for messages of any type, used by tools and views: decoding, selecting fields, expressions, rates."""
