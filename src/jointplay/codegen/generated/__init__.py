"""Generated modules: their files lie in the cache folder, which is part of this package's path."""

import os

__path__.append(os.environ["JOINTPLAY_KERNELS"])
