"""The assessment of a linkage: forces and losses in its joints, and where its motion changes."""
