"""The method for eight trajectories at once, each in a lane of its own."""

N = 7  # positions, and so speeds, of a structure at most
CONTACTS = 6  # at most
FOLDS = 3  # loops of ideal joints, whose dead centres are watched, at most
PHASE = 1 / 3  # of a phase's turn, which is exact, counts as an angle's where steps are bounded
CLOCK = "clock"  # the phase of what nothing forces
