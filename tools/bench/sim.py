"""Time and error of the simulator on one core, compared with a plain numpy matrix Fourier transform in the same
run."""
import os

from measuring import lines, name_and_seconds, peer, row


def measure(binaries):
    found = lines([os.path.join(binaries, "bench_sim")]) + lines([os.path.join(binaries, "bench_poisson")])
    for one in found:
        if one["part"] == "image":
            one["numpy"] = peer("numpy", "numpy_mft.py", one["pixel_arcsec"], one["min_nm"])
        if one["part"] == "poisson":
            one["numpy"] = peer("numpy", "numpy_poisson.py", one["decades"])
    for far in (1e-6, 1e-2):
        mark_front([one for one in found if one["part"] == "choices" and one["displacement_px"] == far])
    return found


def rows(measured):
    best = [one["isa"] for one in measured if one["part"] == "poisson"][-1]
    for one in measured:
        if one["part"] == "image":
            name = f"image of 101 wavelengths, {one['pixel_arcsec']:g}\"/px"
            reference, at = name_and_seconds(one["numpy"]), f"{one['compared']} pixels"
            yield row("image", f"nodes, {one['geometry']}", f"{name}, accuracy 1e-9: {one['nodes']} nodes",
                      one["node_seconds"], one["node_spread"], one["node_error"], "of peak", *reference,
                      one["node_roofline"], True, at)
            yield row("image", f"all, {one['geometry']}", f"{name}, every wavelength", one["seconds"], one["spread"],
                      one["error"], "of peak", *reference, one["roofline"], True, at)
            yield row("create", one["geometry"], f"create a simulator of 101 wavelengths, {one['pixel_arcsec']:g}\"/px, "
                      f"{one['nodes']} nodes", one["create_s"], None, None, None, "the images of both stars",
                      2 * one["node_seconds"], headline=True)
        elif one["part"] == "frames":
            yield row("frames", "noisy", "a noisy frame of the chapter's scene, 256 x 256 px", one["seconds_1095"] / 1095,
                      one["spread_1095"] / 1095, headline=True)
        elif one["part"] == "poisson" and one["isa"] == best:
            means = "1e4 to 1e9" if one["decades"] else "1e4"
            reference = name_and_seconds(one["numpy"], 65536)
            yield row("frames", "Poisson", f"65,536 Poisson counts of means {means}", one["ns"] * 65536e-9,
                      one["spread_ns"] * 65536e-9, None, None, *reference, headline=bool(one["decades"]))
        elif one["part"] == "derivative":
            yield row("derivative", one["what"], f"derivative image, chapter's scene: {one['what']}", one["seconds"])
        elif one["part"] == "choices" and one["displacement_px"] == 1e-6:
            series = "padded FFT" if one["engine"] == "fft" else f"{one['samples']} pupil samples"
            yield row("optics", series, f"chapter, {series}, {one['wavelengths']} wavelengths", one["seconds"], None,
                      one["error"], "of peak", at=f"{one['compared']} pixels")


def mark_front(rows):
    """A row is on the Pareto front if no other row is both faster and more accurate."""
    for row in rows:
        row["front"] = not any(other["seconds"] < row["seconds"] and other["error"] <= row["error"] for other in rows)


def show(rows):
    of = {}
    for row in rows:
        of.setdefault(row["part"], []).append(row)
    machine, = of["machine"]
    print(f"one core, kernels {machine['isa']}, OpenBLAS {machine['blas_core']}; processor seconds, medians\n")
    print("one image, 256 x 256 cells to 256 x 256 px, 101 wavelengths 1 nm apart")
    print("geometry        how                  seconds  error/peak  numpy/ours")
    for row in of["image"]:
        peer = row["numpy"] and row["numpy"]["seconds"]
        ratio = (lambda s: f"{peer / s:10.1f}") if peer else (lambda s: "   no numpy")
        name = f"{row['geometry']} {row['pixel_arcsec']:g}\""
        print(f"{name:15s} {row['nodes']:3d} nodes           {row['node_seconds']:8.4f}     {row['node_error']:.1e} "
              f"{ratio(row['node_seconds'])}")
        print(f"{name:15s} {row['wavelengths']:3d} wavelengths     {row['seconds']:8.4f}     {row['error']:.1e} "
              f"{ratio(row['seconds'])}")
        if peer:
            print(f"{name:15s} numpy, two zgemm    {peer:8.4f}")
    frames, = of["frames"]
    print(f"\nnoisy frames of the chapter's scene: 1095 in {frames['seconds_1095']:.2f} s, 10000 in "
          f"{frames['seconds_10000']:.2f} s ({frames['ns_per_pixel']:.1f} ns per pixel), memory grown by "
          f"{frames['growth_kib']} KiB")
    for row in of["poisson"]:
        ns = row["numpy"] and 1e9 * row["numpy"]["seconds"]
        peer = f"numpy {ns:.1f}, {ns / row['ns']:.1f} x" if ns else "no numpy"
        means = "1e4 to 1e9" if row["decades"] else "1e4"
        print(f"Poisson counts of means {means:10s} {row['isa']:8s} {row['ns']:5.1f} ns per pixel ({peer})")
    print("\nscene                          set-up, s  frame, ms")
    for row in of["stage"]:
        print(f"{row['what']:30s} {row['setup_s']:9.3f} {row['frame_ms']:10.3f}")
    print("\nderivative images of the chapter's scene by            seconds per image")
    for row in of["derivative"]:
        print(f"{row['what']:40s} {row['images']:3d} images {row['seconds']:10.4f}")
    print("\nengine cells wavelengths order displacement, px  seconds  error/peak  shift error, px   (* Pareto front)")
    for row in of["choices"]:
        print(f"{row['engine']:6s} {row['samples']:5d} {row['wavelengths']:11d} {row['order']:5d} "
              f"{row['displacement_px']:16g} {row['seconds']:8.4f}     {row['error']:.1e}          "
              f"{row['shift_error_px']:.1e}   {'*' if row['front'] else ''}")
