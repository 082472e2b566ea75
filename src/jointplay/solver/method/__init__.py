"""The method: an implicit high-order step, events, the event-driven flow; over a structure's functions."""
