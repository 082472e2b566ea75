"""Results: their files, origin and end, and their forms for other programs."""
