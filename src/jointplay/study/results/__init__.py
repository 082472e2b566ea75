"""Results: their files, where they come from, how they ended, and their forms for other programs."""
