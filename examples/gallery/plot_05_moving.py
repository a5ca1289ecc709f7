"""
Stars that move
===============

Orbit, pointing and roll move both stars. A fit of the forward model follows them, and each frame gives its separation.
"""
# %%
# A hundred frames of 64 x 64 px. In the shipped scene ``sky.json`` they are larger.
import numpy
import toliman

times, displacements, frames = toliman.simulate("../data/moving.json")
fit = toliman.Fit("../data/moving.json")
results = fit.frames(frames, times_days=times)
print(f"separation {results['separation_px'][0]:.4f} px at first, {results['separation_px'][-1]:.4f} px at the end")

# %%
# What differs from the orbit at the time of each frame is the displacement. Its errors are those that the fit states.
errors = (results["displacement_px"] - displacements) / results["separation_sigma_px"]
print(f"errors in standard deviations: rms {numpy.sqrt(numpy.mean(errors**2)):.2f}, largest {abs(errors).max():.1f}")

# %%
# The period of the signal is 17 days.
peak = toliman.period(times, results["displacement_px"], results["separation_sigma_px"])
peak.plot()
