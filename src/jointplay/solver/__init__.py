"""The compact rigid and elastic solver: a mechanism in, a motion out."""
