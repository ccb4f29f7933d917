"""Images and methods by simulation, chapters 2 to 4 of the thesis."""
