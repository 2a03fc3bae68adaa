"""Progress of work, as a line on standard error."""

import sys
import time


class Bar:
    """Function of the share that is done, which draws a bar and the time that is left."""

    def __init__(self, file=None, width=32):
        self.file = sys.stderr if file is None else file
        self.width = width
        self.start = time.monotonic()
        self.drawn = None

    def __call__(self, share):
        percent = int(100 * share)
        if percent == self.drawn:
            return
        self.drawn = percent
        full = int(self.width * share)
        seconds = time.monotonic() - self.start
        left = f", {seconds * (1 - share) / share:.0f} s left" if 0 < share < 1 else ""
        line = f"[{'#' * full}{'.' * (self.width - full)}] {percent:3d} %{left}"
        end = "\n" if share >= 1 else ""
        print(f"\r{line:<{self.width + 24}}", end=end, file=self.file, flush=True)


def reporter(progress):
    """Return the function to be called: ``True`` means a bar, ``None`` and ``False`` nothing."""
    if progress is True:
        return Bar()
    if progress in (None, False):
        return None
    if not callable(progress):
        raise TypeError(f"progress={progress!r}: expected True or a function of one number")
    return progress
