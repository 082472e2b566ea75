"""Tangents of the flow, carried through every event."""
