"""Speed of the simulator against its error, on one core, beside a plain numpy matrix transform in the same run.

Usage: bench_sim.py FOLDER RESULT.json. FOLDER holds bench_sim and bench_poisson; numpy is taken from Debian's python3
where it is there."""
import json
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
PYTHON = "/usr/bin/python3"


def environment():
    """One thread, and kernels as new as the processor: Debian's OpenBLAS takes many for older ones."""
    core = "SKYLAKEX" if " avx512f " in open("/proc/cpuinfo").read() else "HASWELL"
    return {"OPENBLAS_CORETYPE": core, **os.environ, "OPENBLAS_NUM_THREADS": "1"}


def measure(program):
    rows = []
    with subprocess.Popen([program], env=environment(), stdout=subprocess.PIPE, text=True) as run:
        for line in run.stdout:
            rows.append(json.loads(line))
            if sys.stderr.isatty():
                print(f"\r{len(rows)} measured", end="", file=sys.stderr)
    if run.returncode != 0:
        sys.exit(run.returncode)
    return rows


def numpy_time(script, *arguments):
    """What a peer's script measures; None without numpy."""
    done = subprocess.run([PYTHON, os.path.join(HERE, script), *map(str, arguments)], env=environment(),
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    return float(done.stdout) if done.returncode == 0 else None


def mark_front(rows):
    """A row is on the Pareto front when no other is both faster and nearer."""
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
        peer = row["numpy_seconds"]
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
          f"{frames['seconds_10000']:.2f} s ({frames['ns_a_pixel']:.1f} ns a pixel), memory grown by "
          f"{frames['growth_kib']} KiB")
    for row in of["poisson"]:
        peer = f"numpy {row['numpy_ns']:.1f}, {row['numpy_ns'] / row['ns']:.1f} x" if row["numpy_ns"] else "no numpy"
        means = "1e4 to 1e9" if row["decades"] else "1e4"
        print(f"Poisson counts of means {means:10s} {row['isa']:8s} {row['ns']:5.1f} ns a pixel ({peer})")
    print("\nscene                          once, s   a frame, ms")
    for row in of["stage"]:
        print(f"{row['what']:30s} {row['setup_s']:7.3f} {row['frame_ms']:13.3f}")
    print("\nengine cells wavelengths order displacement, px  seconds  error/peak  shift error, px   (* Pareto front)")
    for row in of["choices"]:
        print(f"{row['engine']:6s} {row['samples']:5d} {row['wavelengths']:11d} {row['order']:5d} "
              f"{row['displacement_px']:16g} {row['seconds']:8.4f}     {row['error']:.1e}          "
              f"{row['shift_error_px']:.1e}   {'*' if row['front'] else ''}")


def main():
    folder, result = sys.argv[1:]
    rows = measure(os.path.join(folder, "bench_sim")) + measure(os.path.join(folder, "bench_poisson"))
    for row in rows:
        if row["part"] == "image":
            row["numpy_seconds"] = numpy_time("numpy_mft.py", row["pixel_arcsec"], row["min_nm"])
        if row["part"] == "poisson":
            row["numpy_ns"] = numpy_time("numpy_poisson.py", row["decades"])
    for far in (1e-6, 1e-2):
        mark_front([row for row in rows if row["part"] == "choices" and row["displacement_px"] == far])
    show(rows)
    with open(result, "w") as out:
        json.dump(rows, out, indent=1)
    print(f"\n{result}", file=sys.stderr)


main()
