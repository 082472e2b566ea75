"""Mechanisms: validated, frozen records that a person can read, and the models assembled of them."""
