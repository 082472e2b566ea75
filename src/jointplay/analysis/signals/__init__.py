"""What samples of a motion tell: 0-1 test, spectrum, dimension."""
