"""Error against time: what a more exact picture costs."""

import time

from ._petzval import compare

#: Added to the seed for the reference, whose errors must be others than those of the pictures.
_OTHER_SEED = 1_000_003


def measure(render, spp, reference_spp, metric, seed):
    """Return rows of samples, seconds and error; see :func:`petzval.accuracy`.

    :param render: a function of samples and seed that returns an image
    """
    reference = render(reference_spp, (seed + _OTHER_SEED) % 2**32).pixels
    rows = []
    for samples in spp:
        start = time.perf_counter()
        image = render(samples, seed)
        seconds = time.perf_counter() - start
        error = compare(image.pixels, reference, metric)
        rows.append({"spp": samples, "seconds": seconds, "error": error})
    return rows
