"""What tools and views do with messages of any topic: decode them, pick fields, evaluate expressions, measure rates."""
