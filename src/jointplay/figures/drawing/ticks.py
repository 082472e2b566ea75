"""Ticks of axes in degrees: at the parts and multiples of a turn that a reader expects."""

from matplotlib.ticker import Locator, MaxNLocator, MultipleLocator

STEPS = (1, 2, 5, 10, 15, 30, 45, 90, 180, 360, 720, 1800, 3600)
MOST = 6  # intervals on an axis


class Degrees(Locator):
    """Ticks at 45, 90, 180, 360 deg and the like, whichever of them gives at most six intervals."""

    def __call__(self):
        return self.tick_values(*self.axis.get_view_interval())

    def tick_values(self, vmin, vmax):
        """Return the ticks, in deg, of an axis from `vmin` to `vmax`."""
        span = abs(vmax - vmin)
        if span < STEPS[0] or span > MOST * STEPS[-1]:
            return MaxNLocator(MOST, steps=(1, 1.8, 3.6, 9, 10)).tick_values(vmin, vmax)
        step = next(step for step in STEPS if span <= MOST * step)
        return MultipleLocator(step).tick_values(min(vmin, vmax), max(vmin, vmax))
