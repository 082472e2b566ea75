"""One file a quantity: a mechanism and keywords in, a labelled dataset out."""
