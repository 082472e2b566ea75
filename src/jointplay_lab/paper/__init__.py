"""A paper's figures and conclusions: what its motions are, under which reading."""
