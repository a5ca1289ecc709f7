"""Variants of a scene, each with one difference, as merge patches (RFC 7386) of its JSON."""
from __future__ import annotations

import json
import math
import os
import typing

from .._failure import USAGE, Failure
from ..sim import Simulator, plan, scene_path

Json = typing.Any

# Pointing jitter of 1e-3 px and flux jitter of 1e-4, rms per frame.
JITTER = {"systematics": {"pointing_rms_px": 0.001, "flux_rms": 0.0001}}
# Fluxes and shifts projected out of the estimators.
PROJECTED = {"preprocess": {"project": ["flux_a", "flux_b", "shift_x", "shift_y"]}}


def merged(target: Json, patch: Json) -> Json:
    """Returns the JSON value `target` with a merge patch."""
    if not isinstance(patch, dict):
        return patch
    result = dict(target) if isinstance(target, dict) else {}
    for key, value in patch.items():
        if value is None:
            result.pop(key, None)
        else:
            result[key] = merged(result.get(key), value)
    return result


_FLUXES = ("relative_flux", "photons_per_s", "detected_per_s", "magnitude", "magnitude_band", "magnitude_system",
           "zero_point_photons_per_s")


class Variants:
    """Makes simulators of variants of a scene file with two stars."""

    def __init__(self, scene: str, simulator: Simulator):
        path = scene_path(scene)
        with open(path, encoding="utf-8") as file:
            self._scene = json.load(file)
        self._folder = os.path.dirname(path) or "."
        self._a, self._b = simulator.offsets()
        if math.isnan(self._b[0]):
            raise Failure(USAGE, f"{scene}: stars.B: is missing: the tables equal and robust need two stars; give "
                                 "--tables real")
        self._scale_arcsec = simulator.info.pixel_scale_arcsec
        self._middle_nm = simulator.spectrum().wavelength_m[simulator.info.wavelengths // 2] * 1e9

    def _part(self, *keys: str) -> Json:
        """The part of the scene below these keys; None if there is none."""
        part = self._scene
        for key in keys:
            part = part.get(key) if isinstance(part, dict) else None
        return part

    def changed(self, *patches: Json) -> Simulator:
        """Returns the simulator of the scene with merge patches, such as those above."""
        scene = self._scene
        for patch in patches:
            scene = merged(scene, patch)
        return Simulator(scene, folder=self._folder)

    def equal_stars(self) -> Simulator:
        """Both stars equally bright: the mean of their photons, or electrons, if the scene gives these, otherwise relative
        fluxes of 1."""
        light = plan(self._scene, folder=self._folder)
        star: Json = dict.fromkeys(_FLUXES)
        if any("detected_per_s" in self._part("stars", name) for name in "AB"):
            star["detected_per_s"] = sum(light.electrons_per_s) / 2 or 1
        elif min(light.photons_per_s) > 0:
            star["photons_per_s"] = sum(light.photons_per_s) / 2
        else:
            star["relative_flux"] = 1
        return self.changed({"stars": {"A": star, "B": star}})

    def defocused(self, waves_rms: float) -> Simulator:
        """More defocus, Noll's index 4, in waves of the middle wavelength."""
        own = self._part("telescope", "aberrations", "zernike_rms_nm", "4") or 0
        return self.changed({"telescope": {"aberrations": {"zernike_rms_nm": {"4": own + waves_rms * self._middle_nm}}}})

    def moved(self, separation_px: float = 0, shift_px: float = 0, scale: float = 1) -> Simulator:
        """Stars at other positions: the star without signal moved away by separation_px, both stars shifted along a row by
        shift_px, and pixels larger on the sky by `scale`."""
        a, b = ([place[0] / scale + shift_px, place[1] / scale] for place in (self._a, self._b))
        still, moving = (a, b) if self._part("signal", "star") == "B" else (b, a)
        x, y = still[0] - moving[0], still[1] - moving[1]
        distance = math.hypot(x, y)
        still[0] += x / distance * separation_px
        still[1] += y / distance * separation_px
        return self.changed(
            {"binary": None},
            {"binary": {"offsets_px": {"A": a, "B": b}, "distance_pc": self._part("binary", "distance_pc")},
             "detector": {"focal_length_m": None, "pixel_um": None, "pixel_scale_arcsec": scale * self._scale_arcsec}})
