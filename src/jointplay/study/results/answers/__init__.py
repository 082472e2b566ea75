"""Answers of results, in one to three sentences; a file a family of kinds."""
