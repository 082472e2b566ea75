"""Source of the eight-lane kernels: a structure's equations, and the method's algebra and control."""
