"""The physics, written once, as SymPy expressions that read like the model."""
