"""What each node shows of itself: data alone, read by the node and by its reference."""
