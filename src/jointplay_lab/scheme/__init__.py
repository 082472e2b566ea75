"""The paper's own iterative scheme, and how it compares."""
