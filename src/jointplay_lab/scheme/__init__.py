"""The paper's own iterative scheme, and its comparison with the solver."""
