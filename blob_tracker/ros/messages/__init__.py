"""Messages to the types of the rooms, and back, with every field checked."""
