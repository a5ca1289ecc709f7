"""libtoliman for Python: the streaming Lomb-Scargle periodogram over ctypes.

    from toliman import Periodogram
    with Periodogram(f0=1.5 / 1095, df=0.1 / 1095, nf=5461) as periodogram:
        for t, y in samples:
            periodogram.push(t, y)
        print(periodogram.peak().period)

Frequencies are f0 + k df in cycles per unit of t; weights are 1/sigma**2; the power is astropy's "standard", between 0
and 1, never NaN. A failed call raises toliman.Error with the library's message.
"""
from ._library import Error, abi_version, version
from .period import Peak, Periodogram, Sampling

__all__ = ["Error", "Peak", "Periodogram", "Sampling", "abi_version", "version"]
