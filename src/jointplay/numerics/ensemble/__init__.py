"""The method for eight trajectories at once, each in a lane of its own."""
