"""The method for eight trajectories at once, each in a lane of its own."""

N = 7  # positions, and so speeds, of a structure at most
CONTACTS = 3  # at most
