"""Numbers, units and codes as people read them: for figures, and for answers in words."""
