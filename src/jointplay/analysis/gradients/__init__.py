"""Derivatives in parameters: of states, section maps, forces and works."""
