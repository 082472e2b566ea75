"""A paper's figures and conclusions: the character of its motions, under each reading."""
