"""Equations given as text: grammar, form and sliding modes."""
