"""
Compress each frame to one number
=================================

A convolutional autoencoder, trained on the scene, finds the separation in each frame at the photon limit.
"""
# %%
# The chapter's scene, at one wavelength instead of 101 to be quick, with 200 frames.
import json

import numpy
import toliman

scene = json.load(open("../scenes/chapter.json"))
scene["band"] = {"wavelength_nm": 580}
scene["signal"]["amplitude_px"] = 1e-5
simulator = toliman.Simulator(scene)
network = toliman.CAE(simulator)
network.train()

# %%
# Training needs no frames: the decoder becomes the derivative of the image by the separation. The *latent* of a frame is
# its displacement in px.
times, displacements, frames = toliman.simulate(simulator, count=200)
latents = network.encode(frames)
print(f"standard deviation of latents minus truth: {numpy.std(latents - displacements):.3g} px, "
      f"Cramer-Rao bound {simulator.bounds.crb_px:.3g} px")

# %%
# The template, a least-squares fit of the derivative image, has the same noise.
template = toliman.Template(simulator)
print(f"template: {numpy.std(template.encode(frames) - displacements):.3g} px")
toliman.Measurements.of(times, latents, simulator.bounds.crb_px).plot()
