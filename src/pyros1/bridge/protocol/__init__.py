"""What sites send each other: packets, the keys they are sent on, and lists with versions. No I/O."""
