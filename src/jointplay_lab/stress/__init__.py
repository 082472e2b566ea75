"""Whether the method answers truly far outside ordinary use: models drawn at random and from the corners."""
