"""Draws telescopes whose optics nobody knows, for tests of calibrations: only frames of such a scene reach a calibration,
which starts from the nominal scene.

    truth = draw_truth(json.loads(pathlib.Path("sky.json").read_text()), seed=1, mid_nm=1, out="truths")

Distributions, each from a random stream of its own, so that one option does not change what the others draw:

  Zernike coefficients  normal, then scaled to the rms low_nm in total, over the full aperture
  mid frequencies       normal Fourier coefficients of amplitude k^-2.5 at k = 4 to 20 cycles per aperture, in steps of
                        1/2; scaled to the rms mid_nm over the open pupil
  scale, mask rotation  +- the given number: the sign is random
  jitter                covariance of a Gaussian blur with the standard deviations jitter_px along a random direction and
                        0.5 to 1 times that across it
  temperature           normal with standard deviation temperature_k, for each star
  spectral structure    normal coefficients of the Legendre polynomials 1 to 11 over the band, scaled to the relative rms
                        `structure`; or, with structure_kind "nodes", a factor 1 + structure times a normal number at
                        each of 12 nodes across the band, linear between them, for each star
"""
import copy
import pathlib

import numpy

FILES = "file", "opd_file", "times_days", "orbit", "bad_pixels", "response", "qe", "magnitude_band"
NODES, MODES, TABLE_STEP_NM = 12, 11, 0.5
TEMPERATURES = {"A": 5790, "B": 5260}  # that the library assumes for tables without one


def draw_truth(nominal, seed, low_nm=20, mid_nm=0, scale=1e-3, mask_rotation_deg=0.1, jitter_px=0.1, temperature_k=70,
               structure=0, *, structure_kind="modes", zernikes=(4, 11), folder=".", out="."):
    """Returns the scene of a telescope that differs from that of the scene `nominal` at random.

    zernikes: first and last polynomial (Noll). folder: of the files that the scene names; their names become absolute.
    out: folder of the files that are written: the OPD map, and spectra with nodes. A mask gets edges "area".
    """
    scene = copy.deepcopy(nominal)
    streams = [numpy.random.default_rng([seed, number]) for number in range(7)]
    resolve_files(scene, pathlib.Path(folder).resolve())
    stem = pathlib.Path(out).resolve() / f"truth_{seed}"
    telescope = scene["telescope"]
    add_zernikes(telescope, zernikes, low_nm, streams[0])
    if mid_nm:
        add_map(telescope, mid_nm * 1e-9 * mid_frequencies(telescope, streams[1]), f"{stem}.opd.npy")
    scene["detector"]["pixel_scale_arcsec"] /= 1 + scale * sign(streams[2])  # the image is 1 + scale times as large
    mask = telescope.get("mask", {"kind": "clear"})
    if mask["kind"] == "spiral":
        mask["edges"] = "area"
        mask["rotation_deg"] = mask.get("rotation_deg", 0) + mask_rotation_deg * sign(streams[3])
    if jitter_px:
        add_jitter(scene.setdefault("systematics", {}), jitter_px, streams[4])
    for name, star in scene["stars"].items():
        change_temperature(star["spectrum"], TEMPERATURES[name], temperature_k * streams[5].normal())
        if structure:
            add_structure(star["spectrum"], scene["band"], structure, structure_kind, f"{stem}.{name}.csv", streams[6])
    return scene


def true_changes(nominal, truth):
    """Returns what a calibration of `nominal` should find for frames of `truth`, by the names of its parameters; those
    that are not listed have no change."""
    changes = {"scale": nominal["detector"]["pixel_scale_arcsec"] / truth["detector"]["pixel_scale_arcsec"] - 1}
    coefficients, mask, jitter = ([part(scene) for scene in (nominal, truth)] for part in (zernikes_of, mask_of, jitter_of))
    for noll in {**coefficients[0], **coefficients[1]}:
        name = "focus" if noll == "4" else f"zernike_{noll}"
        changes[name] = coefficients[1].get(noll, 0) - coefficients[0].get(noll, 0)
    changes["mask_rotation"] = mask[1].get("rotation_deg", 0) - mask[0].get("rotation_deg", 0)
    for axes in ("xx", "yy", "xy"):
        changes[f"jitter_{axes}"] = jitter[1].get(axes, 0) - jitter[0].get(axes, 0)
    for star in nominal["stars"]:
        given, true = (temperature_of(scene["stars"][star]["spectrum"], star) for scene in (nominal, truth))
        changes[f"temperature_{star.lower()}"] = true - given
        before, after = (scene["stars"][star]["spectrum"].get("modes", []) for scene in (nominal, truth))
        for k, mode in enumerate(after):
            changes[f"spectrum_{star.lower()}_{k + 1}"] = mode - (before[k] if k < len(before) else 0)
    return changes


def zernikes_of(scene):
    return scene["telescope"].get("aberrations", {}).get("zernike_rms_nm", {})


def mask_of(scene):
    return scene["telescope"].get("mask", {})


def jitter_of(scene):
    systematics = scene.get("systematics", {})
    rms = systematics.get("jitter_sigma_px", 0)
    return systematics.get("jitter_covariance_px2", {"xx": rms**2, "yy": rms**2})


def temperature_of(spectrum, star):
    return spectrum.get("temperature_k", spectrum.get("star_temperature_k", TEMPERATURES[star]))


def sign(stream):
    return stream.choice([-1, 1])


def resolve_files(part, folder):
    """Makes the names of files in a scene absolute."""
    for key, value in part.items():
        if isinstance(value, dict):
            resolve_files(value, folder)
        elif isinstance(value, list):
            part[key] = [str(folder / item) if key == "throughput" and isinstance(item, str) else item for item in value]
        elif key in FILES and isinstance(value, str) and value not in ("alpha-cen", "V"):
            part[key] = str(folder / value)


def add_zernikes(telescope, zernikes, rms_nm, stream):
    first, last = zernikes
    coefficients = stream.normal(size=last - first + 1)
    coefficients *= rms_nm / numpy.linalg.norm(coefficients)
    given = telescope.setdefault("aberrations", {}).setdefault("zernike_rms_nm", {})
    for noll, coefficient in enumerate(coefficients, first):
        given[str(noll)] = given.get(str(noll), 0) + coefficient


def add_map(telescope, opd_m, path):
    """Adds an OPD map to that of the telescope, if it has one."""
    aberrations = telescope.setdefault("aberrations", {})
    if "opd_file" in aberrations:
        opd_m = opd_m + numpy.load(aberrations["opd_file"])
    numpy.save(path, numpy.ascontiguousarray(opd_m))
    aberrations["opd_file"] = path


def mid_frequencies(telescope, stream):
    """An OPD map [N][N] of rms 1 over the open pupil, of mean 0: filtered noise on a square of two apertures a side, so
    that it is not periodic over the aperture."""
    n = telescope.get("pupil_samples", 256)
    frequency = numpy.fft.fftfreq(2 * n, 0.5 / n)  # cycles per aperture
    k = numpy.hypot(frequency[:, None], frequency)
    amplitude = numpy.where((k >= 4) & (k <= 20), numpy.maximum(k, 1) ** -2.5, 0)
    noise = numpy.fft.ifft2(amplitude * numpy.fft.fft2(stream.normal(size=(2 * n, 2 * n)))).real[:n, :n]
    x = (numpy.arange(n) + 0.5) * 2 / n - 1
    r = numpy.hypot(x[:, None], x)
    opened = (r <= 1) & (r >= telescope.get("secondary_m", 0) / telescope["aperture_m"])
    return (noise - noise[opened].mean()) / noise[opened].std()


def add_jitter(systematics, jitter_px, stream):
    """Adds the covariance of a blur to that of the scene."""
    across = jitter_px * stream.uniform(0.5, 1)
    angle = stream.uniform(0, numpy.pi)
    c, s = numpy.cos(angle), numpy.sin(angle)
    before = jitter_of({"systematics": systematics})
    systematics.pop("jitter_sigma_px", None)
    systematics["jitter_covariance_px2"] = {
        "xx": before["xx"] + (c * jitter_px) ** 2 + (s * across) ** 2,
        "yy": before["yy"] + (s * jitter_px) ** 2 + (c * across) ** 2,
        "xy": before.get("xy", 0) + c * s * (jitter_px**2 - across**2)}


def change_temperature(spectrum, assumed_k, change_k):
    if spectrum["kind"] == "blackbody":
        spectrum["temperature_k"] += change_k
    elif spectrum["kind"] == "table":
        given = spectrum.setdefault("table_temperature_k", assumed_k)
        spectrum["star_temperature_k"] = spectrum.get("star_temperature_k", given) + change_k


def add_structure(spectrum, band, rms, kind, path, stream):
    if kind == "modes":
        degrees = numpy.arange(1, MODES + 1)
        coefficients = stream.normal(size=MODES) * numpy.sqrt(2 * degrees + 1)
        coefficients *= rms / numpy.sqrt((coefficients**2 / (2 * degrees + 1)).sum())
        given = spectrum.get("modes", [])
        spectrum["modes"] = [c + (given[k] if k < len(given) else 0) for k, c in enumerate(coefficients.tolist())]
        return
    if kind != "nodes" or spectrum["kind"] != "table":
        raise ValueError(f"structure_kind = {kind!r}: must be modes, or nodes for a spectrum of kind table")
    table = numpy.array([row for row in (numbers(line) for line in open(spectrum["file"], encoding="utf-8")) if row])
    wavelengths = numpy.arange(band["min_nm"], band["max_nm"] + TABLE_STEP_NM / 2, TABLE_STEP_NM)
    nodes = numpy.linspace(band["min_nm"], band["max_nm"], NODES)
    factor = 1 + rms * numpy.interp(wavelengths, nodes, stream.normal(size=NODES))
    numpy.savetxt(path, numpy.c_[wavelengths, factor * numpy.interp(wavelengths, *table.T)], delimiter=",", fmt="%.9g",
                  header="wavelength_nm,relative_photon_flux", comments="")
    spectrum["file"] = path


def numbers(line):
    """The numbers of a line of a table, None for a comment or a heading."""
    try:
        return [float(word) for word in line.split(",")]
    except ValueError:
        return None
