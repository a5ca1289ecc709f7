"""Scenes from the parameters of dLuxToliman.

    python3 -m toliman.dlux parameters.json scene.json

The parameters are the arguments of its classes by name, such as

    {"TolimanOpticalSystem": {"psf_npixels": 256}, "AlphaCen": {"separation": 8, "position_angle": 30, "log_flux": 7.832},
     "GaussianJitter": {"r": 0.01}}

What a scene cannot express is refused by name. A scene differs from dLuxToliman where that approximates: pixels are
integrated and images smeared exactly, not in oversample or n_psfs samples; edges of the pupil have their exact areas; the
flux is that through the open area, not through the squared transmission (0.5 % more light). The default mask is in a file
of dLuxToliman, which this package has not: the scene then has the mask of the shipped mission, with a warning.
"""
from __future__ import annotations

import argparse
import json
import math
import os
import pathlib
import sys
import typing
import warnings
from fractions import Fraction

from ._failure import OUTPUT, USAGE, Failure, malformed, readable
from ._output import print_text

Values = typing.Mapping[str, typing.Any]

_REFUSED = {
    "TolimanSpikes": "give TolimanOpticalSystem, the centre of the image, and add detector.sidelobe to the scene for the window around an order",
    "MixedAlphaCen": "give the mixture as AlphaCen.weights, or as a table in stars.A.spectrum of a scene",
}
_MASK = {"kind": "spiral", "opd_nm": 292.5, "terms": [
    {"a": 0.819, "f": 2.918, "l": 0, "m": -27, "p": 4.874}, {"a": 0.93, "f": 1.829, "l": 0, "m": 25, "p": 5.967},
    {"a": 0.702, "f": 9.468, "l": 10.905, "m": -27, "p": 4.193}]}  # of mission.json


class Arguments:
    """The arguments of a class of dLuxToliman, of which all must be read."""

    def __init__(self, name: str, values: typing.Any):
        if not isinstance(values, dict):
            raise ValueError(f"{name}: must be an object with the arguments of the class")
        self._name, self._values, self._read = name, values, set[str]()

    def refuse(self, key: str, why: str) -> typing.NoReturn:
        """Raises ValueError with the name of the argument."""
        raise ValueError(f"{self._name}.{key}: {why}")

    def get(self, key: str, default: typing.Any = None) -> typing.Any:
        """Returns the value of an argument of any type."""
        self._read.add(key)
        return self._values.get(key, default)

    def number(self, key: str, default: float | None, missing: str = "is missing") -> float:
        """Returns a number; without a default it must be given."""
        value = self.get(key, default)
        if value is None:
            self.refuse(key, missing)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            self.refuse(key, f"{json.dumps(value)}: must be a number")
        return value

    def whole(self, key: str, default: int) -> int:
        """Returns a whole number above 0."""
        value = self.number(key, default)
        if value != int(value) or value < 1:
            self.refuse(key, f"{value}: must be a whole number above 0")
        return int(value)

    def numbers(self, key: str) -> list[float] | None:
        """Returns a list of numbers, None if it is not given."""
        values = self.get(key)
        if values is None:
            return None
        if not isinstance(values, list) or not all(
                isinstance(value, (int, float)) and not isinstance(value, bool) for value in values):
            self.refuse(key, "must be an array of numbers")
        return values

    def ignore(self, *keys: str) -> None:
        """Accepts arguments of approximations that a scene computes exactly."""
        self._read.update(keys)

    def finish(self) -> None:
        """Refuses arguments that were not read."""
        for key in self._values:
            if key not in self._read:
                self.refuse(key, "a scene cannot express it")


def _orders(noll: int) -> tuple[int, int, bool]:
    """The radial and azimuthal order of Noll's polynomial, and whether it is a sine."""
    order, place = 0, noll - 1
    while place > order:
        order += 1
        place -= order
    azimuth = order % 2 + 2 * ((place + (order + 1) % 2) // 2)
    return order, azimuth, azimuth > 0 and noll % 2 == 1


def _radial(order: int, azimuth: int) -> dict[int, Fraction]:
    """The coefficients of a radial polynomial by power of r, without the norm sqrt(order + 1)."""
    plus, minus = (order + azimuth) // 2, (order - azimuth) // 2
    return {order - 2 * k: Fraction((-1) ** k * math.factorial(order - k),
                                    math.factorial(k) * math.factorial(plus - k) * math.factorial(minus - k))
            for k in range(minus + 1)}


def _oversized(noll: int, size: float) -> dict[int, float]:
    """A polynomial over a circle that is `size` times as large, as a sum of those over the circle, by Noll index."""
    order, azimuth, sine = _orders(noll)
    shrunk = {power: value / Fraction(size) ** power for power, value in _radial(order, azimuth).items()}
    shares = {}
    for lower in range(azimuth, order + 1, 2):
        # R_lower is orthogonal: the integral of R_lower^2 r dr is 1/(2 (lower + 1)).
        overlap = sum(a * b / (i + j + 2) for i, a in shrunk.items() for j, b in _radial(lower, azimuth).items())
        first = lower * (lower + 1) // 2 + 1
        index = next(j for j in range(first, first + lower + 1) if _orders(j) == (lower, azimuth, sine))
        shares[index] = float(2 * (lower + 1) * overlap) * math.sqrt((order + 1) / (lower + 1))
    return shares


def _zernikes(optics: Arguments) -> dict[str, float]:
    orders, indices = optics.numbers("radial_orders"), optics.numbers("noll_indices")
    if orders is not None:  # n has the indices n (n + 1)/2 + 1 to (n + 1)(n + 2)/2
        indices = [first + k for n in orders for first in [n * (n + 1) // 2 + 1] for k in range(int(n) + 1)]
    coefficients = optics.numbers("coefficients") or []
    if indices is None or not any(coefficients):
        optics.ignore("z_oversize")
        return {}
    if len(coefficients) != len(indices):
        optics.refuse("coefficients", f"has {len(coefficients)} numbers: must have {len(indices)}, one per polynomial")
    size = optics.number("z_oversize", None, "is missing: 1.01 in versions that have this argument, 1 in those before")
    rms_nm: dict[int, float] = {}
    for noll, metres in zip(indices, coefficients):
        for j, share in (_oversized(int(noll), size) if size != 1 else {int(noll): 1.0}).items():
            rms_nm[j] = rms_nm.get(j, 0) + share * metres * 1e9
    return {str(j): value for j, value in sorted(rms_nm.items()) if j > 1}  # without piston


def _telescope(optics: Arguments) -> dict[str, typing.Any]:
    if optics.number("n_struts", 3) != 3:
        optics.refuse("n_struts", "dLuxToliman draws three struts whatever it says: give 3")
    optics.ignore("strut_rotation", "oversample")  # dLuxToliman does not use the rotation
    mask = optics.get("mask")
    if mask is None:
        warnings.warn("TolimanOpticalSystem.mask: dLuxToliman's file diffractive_pupil.npy is not here: the scene has the "
                      "mask of mission.json", stacklevel=4)
    elif not isinstance(mask, str):
        optics.refuse("mask", "must be the name of an .npy file with the OPD in m, wf_npixels x wf_npixels")
    telescope = {
        "aperture_m": optics.number("m1_diameter", 0.125), "secondary_m": optics.number("m2_diameter", 0.032),
        "struts": {"count": 3, "width_m": optics.number("strut_width", 0.002), "angle_deg": 30},  # theirs: 0 is to -y
        "pupil_samples": optics.whole("wf_npixels", 256),
        "mask": _MASK if mask is None else {"kind": "file", "quantity": "opd_m", "file": mask}}
    zernikes = _zernikes(optics)
    return {**telescope, "aberrations": {"zernike_rms_nm": zernikes}} if zernikes else telescope


def _stars(source: Arguments, pixel: float) -> tuple[dict[str, typing.Any], dict[str, typing.Any]]:
    flux = 10 ** source.number("log_flux", None, "is missing: its default differs between versions of dLuxToliman")
    contrast = source.number("contrast", 3.37)
    count = source.whole("n_wavels", 3)
    band = source.numbers("bandpass") or [530, 640]
    wavelengths = [band[0] + (band[1] - band[0]) * i / max(count - 1, 1) for i in range(count)]
    weights = source.get("weights") or [[1] * count] * 2
    if len(weights) != 2 or any(not isinstance(row, list) or len(row) != count for row in weights):
        source.refuse("weights", f"must be two arrays, of A and B, of n_wavels = {count} numbers")
    photons = {"A": flux * contrast / (1 + contrast), "B": flux / (1 + contrast)}
    stars = {star: {"spectrum": {"kind": "lines", "wavelength_nm": wavelengths, "weight": row}, "photons_per_s": photons[star]}
             for star, row in zip("AB", weights)}
    half, angle = source.number("separation", 10) / 2, math.radians(source.number("position_angle", 90))
    x, y = source.number("x_position", 0), source.number("y_position", 0)
    places = {star: [(x + sign * half * math.sin(angle)) / pixel, (y + sign * half * math.cos(angle)) / pixel]
              for star, sign in (("A", 1), ("B", -1))}
    return stars, {"offsets_px": places}


def _gaussian(jitter: Arguments, pixel: float) -> dict[str, typing.Any]:
    shear, angle = jitter.number("shear", 0), math.radians(jitter.number("phi", 0))
    if not 0 <= shear < 1:
        jitter.refuse("shear", f"{shear}: must be in [0, 1)")
    jitter.ignore("kernel_size", "kernel_oversample")
    longer = math.sqrt(jitter.number("r", None) / (1 - shear))  # variance, arcsec^2
    shorter = longer * (1 - shear) ** 2
    cosine, sine = math.cos(angle), math.sin(angle)
    covariance = {"xx": longer * cosine**2 + shorter * sine**2, "yy": longer * sine**2 + shorter * cosine**2,
                  "xy": (longer - shorter) * sine * cosine}
    return {"jitter_covariance_px2": {key: value / pixel**2 for key, value in covariance.items()}}


def _smear(jitter: Arguments, pixel: float) -> dict[str, typing.Any]:
    kinds = {"linear": "linear", "shm": "harmonic"}
    shape = jitter.get("jitter_shape", "linear")
    if shape not in kinds:
        jitter.refuse("jitter_shape", f"{json.dumps(shape)}: must be \"linear\" or \"shm\"")
    jitter.ignore("n_psfs")
    return {"smear": {"kind": kinds[shape], "length_px": jitter.number("jitter_mag", None) / pixel,
                      "angle_deg": jitter.number("jitter_angle", None)}}


def _harmonic(jitter: Arguments, pixel: float) -> dict[str, typing.Any]:
    angle = jitter.number("phi", None)
    if angle % 90 != 0:
        jitter.refuse("phi", f"{angle}: must be a multiple of 90: the sense of rotation differs between versions of dLux; "
                             "JitteredToliman with jitter_shape \"shm\" has any angle")
    jitter.ignore("kernel_size")
    return {"smear": {"kind": "harmonic", "length_px": 2 * jitter.number("A", None) / pixel, "angle_deg": angle}}


_BLURS = {"GaussianJitter": _gaussian, "JitteredToliman": _smear, "SHMJitter": _harmonic}


def scene(parameters: Values) -> dict[str, typing.Any]:
    """Returns a scene of one frame, one second long, as Simulator() takes it.

    parameters: class of dLuxToliman -> arguments of its constructor, as above. Lengths and angles are in its units.
    Raises ValueError for what a scene cannot express.
    """
    for name in parameters:
        if name in _REFUSED:
            raise ValueError(f"{name}: {_REFUSED[name]}")
        if name not in ("TolimanOpticalSystem", "AlphaCen", "ApplyPixelResponse", "Downsample", *_BLURS):
            raise ValueError(f"{name}: a scene cannot express it; it knows TolimanOpticalSystem, AlphaCen, "
                             f"ApplyPixelResponse, Downsample, {', '.join(_BLURS)}")
    defaults: Values = {"TolimanOpticalSystem": {}, "AlphaCen": {}}
    groups = {name: Arguments(name, values) for name, values in {**defaults, **parameters}.items()}
    optics, source = groups["TolimanOpticalSystem"], groups["AlphaCen"]
    pixel, side = optics.number("psf_pixel_scale", 0.375), optics.whole("psf_npixels", 128)
    detector: dict[str, typing.Any] = {"shape": [side, side], "pixel_scale_arcsec": pixel, "pixel": "integrated"}
    if "ApplyPixelResponse" in groups:
        response = groups["ApplyPixelResponse"].get("pixel_response")
        if not isinstance(response, str):
            groups["ApplyPixelResponse"].refuse("pixel_response", "must be the name of an .npy file")
        detector["response"] = response
    if "Downsample" in groups:
        groups["Downsample"].ignore("kernel_size")
    blurs: dict[str, typing.Any] = {}
    for name, blur in _BLURS.items():
        if name in groups:
            found = blur(groups[name], pixel)
            if blurs.keys() & found.keys():
                raise ValueError(f"{name}: a scene has one smear")
            blurs.update(found)
    stars, binary = _stars(source, pixel)
    made = {"schema": "toliman-scene/1", "telescope": _telescope(optics), "stars": stars, "binary": binary,
            "cadence": {"frames": 1, "exposure_s": 1}, "detector": detector}
    for group in groups.values():
        group.finish()
    return {**made, "systematics": blurs} if blurs else made


def _moved(name: str, start: pathlib.Path, end: pathlib.Path) -> str:
    """A file name that is relative to `start`, relative to `end`."""
    return name if os.path.isabs(name) else os.path.relpath(start / name, end)


def convert(source: pathlib.Path, target: pathlib.Path) -> None:
    """Writes the scene of a file of parameters."""
    try:
        parameters = json.loads(source.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise malformed(source, str(error)) from error
    if not isinstance(parameters, dict):
        raise malformed(source, "must be an object: class -> arguments")
    try:
        made = scene(parameters)
    except ValueError as error:
        raise Failure(USAGE, f"{readable(source)}: {error}") from error
    for group, key in ((made["telescope"]["mask"], "file"), (made["detector"], "response")):
        if key in group:
            group[key] = _moved(group[key], source.parent, target.parent)
    try:
        target.write_text(json.dumps(made, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise Failure(OUTPUT, f"{readable(target)}: {error.strerror}") from error


def main(words: list[str] | None = None) -> int:
    """Runs the program; returns its exit code."""
    parser = argparse.ArgumentParser(prog="python3 -m toliman.dlux", description="Convert parameters of dLuxToliman, the "
                                     "arguments of its classes by name, to a scene.")
    parser.add_argument("parameters", type=pathlib.Path, metavar="PARAMETERS.json")
    parser.add_argument("scene", type=pathlib.Path, metavar="SCENE.json")
    options = parser.parse_args(words)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            convert(options.parameters, options.scene)
        for warning in caught:
            print(f"toliman: warning: {warning.message}", file=sys.stderr)
        print_text(readable(options.scene) + "\n")
    except Failure as failure:
        print(f"toliman: {failure}", file=sys.stderr)
        return failure.code
    return 0


if __name__ == "__main__":
    sys.exit(main())
