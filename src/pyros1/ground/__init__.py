"""What all rooms stand on: errors, names, times, expressions, and the words on the screen."""
