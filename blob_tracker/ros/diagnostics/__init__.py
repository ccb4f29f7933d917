"""What a node says of itself, and what it has to know for that."""
