"""Where a mechanism is: chains cut at its clearances, ideal loops and how they close."""
