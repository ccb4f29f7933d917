"""Where the thesis could not go."""
