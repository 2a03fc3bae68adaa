"""Report of a lens: its first-order data and the quality of its image, as plain numbers."""

import math

import numpy as np

#: Frequencies of the modulation transfer in a report (cycles/mm).
FREQUENCIES = (10.0, 20.0, 40.0)


def report(lens, frequencies=FREQUENCIES, **conditions):
    """Return a dictionary that JSON can hold; see :meth:`petzval.Lens.report`."""
    quality = lens.image_quality(**conditions)
    tangential, sagittal = quality.mtf(frequencies)
    curve = quality.distortion(20)
    fields = []
    for i, (field, height) in enumerate(zip(quality.fields, quality.image_heights)):
        spot = quality.spot(i)
        fields.append(
            {
                "field": _number(field),
                "image_height": _number(height),
                "spot_rms": _number(spot["rms"]),
                "mtf_tangential": [_number(x) for x in tangential[i]],
                "mtf_sagittal": [_number(x) for x in sagittal[i]],
            }
        )
    return {
        "name": lens.name,
        "surfaces": len(lens.surfaces),
        "efl": _number(lens.efl),
        "bfd": _number(lens.bfd),
        "fno": None if lens.fno is None else _number(lens.fno),
        "film_distance": _number(quality.film_distance),
        "wavelengths": [_number(x) for x in quality.wavelengths],
        "field_kind": quality.field_kind,
        "frequencies": [_number(x) for x in frequencies],
        "fields": fields,
        "largest_distortion": _number(_largest(curve["distortion"])),
    }


def _largest(values):
    """Return the number of the largest magnitude, or NaN if there is none."""
    finite = values[np.isfinite(values)]
    return finite[np.argmax(np.abs(finite))] if finite.size else math.nan


def _number(value):
    """Return a float, or None in place of one that JSON cannot hold."""
    value = float(value)
    return value if math.isfinite(value) else None
