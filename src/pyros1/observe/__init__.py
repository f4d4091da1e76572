"""Functions of tools and views for messages of any type: decoding, selecting fields, expressions, rates."""
