"""The foundation of all other packages: errors, names, times, expressions and terminal output."""
