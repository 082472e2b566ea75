"""Whether the method answers truly far outside ordinary use: scenes drawn at random and from the corners."""
