"""
Calibrate the telescope from its own frames
===========================================

Aberrations of a nanometre bias the separation by hundreds of Earths. They are found in the frames themselves.
"""
# %%
# The telescope of the frames has 5 nm of focus and of a coma, which the nominal scene does not know.
import json
import os
import tempfile
import warnings

import numpy
import toliman

nominal = json.load(open("../data/moving.json"))
truth = json.loads(json.dumps(nominal))
truth["telescope"]["aberrations"] = {"zernike_rms_nm": {"4": 5, "7": 5}}
times, _, frames = toliman.simulate(truth, count=8)

# %%
# With the nominal optics, chi-square says that the model is wrong.
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    results = toliman.Fit(nominal).frames(frames, times_days=times)
print(caught[0].message)
print(f"chi-square {numpy.median(results['chi_square']):.1f}")

# %%
# A calibration fits them, with the places of the stars in all frames.
calibration = toliman.calibrate(nominal, frames, times_days=times, free=["focus", "zernike_5-8"])
print(calibration.verdict)
calibration.plot()

# %%
for name, value in calibration.values().items():
    print(f"{name:10} {value.value:6.3f} +- {value.sigma:.3f} {value.unit}")

# %%
# The fitted scene is that of all further estimates.
folder = tempfile.mkdtemp()
calibration.save(os.path.join(folder, "fitted.json"))
results = toliman.Fit(os.path.join(folder, "fitted.json")).frames(frames, times_days=times)
print(f"chi-square {numpy.median(results['chi_square']):.3f}")
