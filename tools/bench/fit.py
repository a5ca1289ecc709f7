"""Time and error of the fit of the forward model on one core, compared with numpy and Fourier-shifted images, which fits
the same frames."""
import os
import tempfile

from measuring import SHORT, lines, peer, row

FRAMES = 10 if SHORT else 80
SCENE = "fit a frame of sky.json, 256 x 256 px"
WHAT = {"0.3": f"{SCENE}, prediction off by 0.3 px rms", "0.03": f"{SCENE}, prediction off by 0.03 px rms",
        "exact": f"{SCENE}, exact prediction",
        "free": f"{SCENE}, with focus, scale and jitter free, prediction off by 0.3 px rms"}


BANK = {"near": "exact", "far": "off by 5e-3 px"}


def measure(binaries):
    with tempfile.TemporaryDirectory() as folder:
        found = lines([os.path.join(binaries, "bench_fit"), FRAMES, folder])
        return found + [{"part": "numpy", "result": peer("numpy", "numpy_fit.py", folder)}]


def errors(one):
    """Arguments of a row: the error of the separation in standard deviations of the fit."""
    return {"error": one["rms_pull"], "of": "of sigma, rms", "at": f"{one['frames']} frames",
            "error_largest": one["largest_pull"]}


def rows(measured):
    parts = {one["part"]: one for one in measured}
    image, numpy = parts["image"], parts["numpy"]["result"]
    of_numpy = (numpy["name"], numpy["seconds"]) if numpy else (None, None)
    for one in measured:
        if one["part"] == "fit":
            reference = of_numpy if one["what"] == "0.3" else ("the model image", image["seconds"])
            yield row("fit", one["what"], WHAT[one["what"]], one["seconds"], one["spread"], reference=reference[0],
                      reference_seconds=reference[1], roofline=one["roofline"], headline=True, steps=one["steps"], **errors(one))
    if numpy:
        yield row("fit", "numpy", f"numpy, Fourier shifts: {WHAT['0.3']}", numpy["seconds"],
                  headline=True, steps=numpy["steps"], **errors(numpy))
    yield row("fit", "model image", "model image of sky.json, 256 x 256 px", image["seconds"], image["spread"], image["error"],
              "of peak", roofline=image["roofline"], headline=True, at=f"{image['compared']} propagated frames")
    for one in measured:
        if one["part"] == "bank":
            yield row("fit", "bank " + one["what"], f"encode the frame by a network of a bank, beyond the fit, predicted "
                      f"separation {BANK[one['what']]}", one["seconds"], one["spread"], headline=True)
    yield row("fit", "create", "create the fit of sky.json, 256 x 256 px", parts["create"]["seconds"], headline=True)


def show(measured):
    parts = {one["part"]: one for one in measured}
    image, numpy = parts["image"], parts["numpy"]["result"]
    print(f"model image: {1e3 * image['seconds']:.3f} ms, {image['taps']} taps, {image['oversampling']} samples per px, error "
          f"{image['error']:.1e} of peak (predicted {image['predicted_error']:.1e})\n")
    for one in measured:
        if one["part"] == "bank":
            print(f"network of a bank, beyond the fit, predicted separation {BANK[one['what']]}: "
                  f"{1e3 * one['seconds']:.3f} ms")
    print("\nprediction          parameters  steps  frame, ms  model images  rms error  largest error, sigma  searched")
    for one in [one for one in measured if one["part"] == "fit"] + ([numpy] if numpy else []):
        print(f"{one.get('what', 'numpy, off by 0.3'):20s} {one.get('parameters', 7):9d} {one['steps']:6g} {1e3 * one['seconds']:10.3f} "
              f"{one['seconds'] / image['seconds']:13.1f} {one['rms_pull']:10.3f} {one['largest_pull']:21.2f} "
              f"{one.get('searched', ''):>9}")
