"""Shares of the mechanisms made by one drawing."""
