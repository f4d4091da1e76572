"""What tools and views need for messages of any type: decoding, field paths, expressions and statistics."""
