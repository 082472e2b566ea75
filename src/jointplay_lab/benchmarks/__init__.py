"""Published mechanisms whose answers are published too: computed and printed numbers compared."""
