"""
A frame, and what a planet changes
==================================

A phase mask in the pupil turns each star into sharp fringes. A planet changes the separation of the stars by a millionth
of a pixel.
"""
# %%
# A :class:`Simulator` prepares a scene: one that is shipped with the library, a file or a dict. Here is a frame with
# photon noise, and the pupil that makes it.
import toliman

simulator = toliman.Simulator("chapter.json")
simulator.plot_frame(0)

# %%
simulator.plot_pupil()

# %%
# The derivative of the image by the separation, times the displacement by the planet, is the change: a hundredth of the
# noise of the brightest pixels. Summed over all pixels, it is known with the Cramer-Rao bound of a frame.
displacement = simulator.info.amplitude_px
change = displacement * simulator.image("separation")
noise = simulator.image("variance") ** 0.5
print(f"largest change: {abs(change).max():.0f} photons; noise there: {noise.flat[abs(change).argmax()]:.0f} photons")
print(f"bound of one frame: {simulator.bounds.crb_px:.2g} px; the planet: {displacement:.2g} px")
simulator.bounds
