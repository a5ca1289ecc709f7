"""`toliman calibrate` as users run it, start-up included: ten frames of 1e10 photons of the scene `sky`, seen by a telescope
that differs from it, with the default parameters. The wavelengths are coarser than those of the scene, in truth and
model alike, which takes seconds instead of minutes."""
import csv
import json
import os
import shutil
import tempfile

from commands import SCENES, shipped_scene, timed
from measuring import SHORT, median_spread, row

FRAMES, PHOTONS, DAYS = (4 if SHORT else 10), 1e10, 1095
STEP_NM = 27.5
REPEATS = 1 if SHORT else 3
# Of the true telescope: aberrations of 20 nm rms, and changes of the size that lib/calibrate expects.
ABERRATIONS_NM = {"4": 9, "5": -12, "7": 8, "8": -10, "11": 5}
SCALE, ROTATION_DEG, JITTER_PX2 = 1e-3, 0.1, {"xx": 0.01, "yy": 0.006, "xy": 0.002}


def nominal_scene():
    scene = shipped_scene("sky")
    scene["telescope"]["mask"] = {**shipped_scene("mission")["telescope"]["mask"], "edges": "area"}  # it can rotate
    scene["band"]["step_nm"] = STEP_NM
    photons_per_s = sum(star["detected_per_s"] for star in scene["stars"].values())
    scene["cadence"] = {"frames": FRAMES, "interval_days": DAYS / (FRAMES - 1), "exposure_s": PHOTONS / photons_per_s}
    del scene["signal"], scene["preprocess"]
    return scene


def true_scene():
    scene = nominal_scene()
    scene["telescope"]["aberrations"] = {"zernike_rms_nm": ABERRATIONS_NM}
    scene["telescope"]["mask"]["rotation_deg"] = ROTATION_DEG
    scene["detector"]["pixel_scale_arcsec"] /= 1 + SCALE
    scene["systematics"]["jitter_covariance_px2"] = JITTER_PX2
    return scene


def write_inputs(program, folder):
    """Both scenes and the frames of the true one. Returns the true separations, px."""
    for star in nominal_scene()["stars"].values():
        shutil.copy(os.path.join(SCENES, star["spectrum"]["file"]), folder)
    for name, scene in (("nominal", nominal_scene()), ("truth", true_scene())):
        with open(os.path.join(folder, name + ".json"), "w") as file:
            json.dump(scene, file)
    timed([program, "simulate", "truth.json", "--out", "frames.fits"], folder)
    found = csv.DictReader(timed([program, "encode", "--fit", "truth.json", "frames.fits"], folder)["out"].splitlines())
    return [float(one["separation_px"]) - float(one["displacement_px"]) for one in found]


def measure(binaries):
    program = os.path.join(os.path.abspath(binaries), "toliman")
    with tempfile.TemporaryDirectory() as folder:
        separations = write_inputs(program, folder)
        runs = [timed([program, "calibrate", "nominal.json", "frames.fits", "--out", "fitted.json", "--json"], folder)
                for _ in range(REPEATS)]
    found = json.loads(runs[0].pop("out"))
    pulls = [(one["separation_px"] - true) / one["separation_sigma_px"]
             for one, true in zip(found["separations"], separations)]
    return {"runs": [{key: value for key, value in one.items() if key != "out"} for one in runs],
            "frames": found["frames"], "parameters": len(found["windows"][0]["parameters"]),
            "iterations": found["iterations"], "verdict": found["verdict"], "chi_square": found["chi_square"],
            "separation_sigma_px": found["separation_sigma_px"], "calibration_sigma_px": found["calibration_sigma_px"],
            "rms_pull": (sum(pull**2 for pull in pulls) / len(pulls))**0.5, "largest_pull": max(map(abs, pulls))}


def rows(measured):
    processor, wall, memory = (median_spread([one[key] for one in measured["runs"]])
                               for key in ("processor_s", "wall_s", "memory_bytes"))
    yield row("calibrate", "sky", f"toliman calibrate sky.json, wavelengths every {STEP_NM} nm: {measured['frames']} frames, "
              f"{measured['parameters']} parameters", *processor, measured["rms_pull"], "of sigma, rms", headline=True,
              at=f"{measured['frames']} frames", error_largest=measured["largest_pull"], steps=measured["iterations"],
              wall_seconds=wall[0], memory_bytes=memory[0])


def show(measured):
    wall = median_spread([one["wall_s"] for one in measured["runs"]])[0]
    print(f"{'; '.join(measured['verdict'])}: chi-square {measured['chi_square']:.4f}, {measured['iterations']} iterations, "
          f"{wall / measured['iterations']:.2f} s each (wall time)\n"
          f"separation of a frame: sigma {measured['separation_sigma_px']:.2e} px, of which the calibration adds "
          f"{measured['calibration_sigma_px']:.1e} px; error {measured['rms_pull']:.3f} sigma rms, largest "
          f"{measured['largest_pull']:.2f} sigma")
