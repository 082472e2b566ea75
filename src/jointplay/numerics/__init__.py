"""The method: an implicit high-order step, events, and the event-driven flow, over functions that a structure supplies."""
