"""Reports on what the tracker does, as pictures and numbers."""
