"""Error against run time: the method and its peers on the same equations."""
