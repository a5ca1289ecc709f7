"""The autoencoder's times on one core against the processor's peak, and against PyTorch and oneDNN where they are
installed (Debian's python3-torch, libdnnl-dev).

Usage: bench_cae.py FOLDER RESULT.json; FOLDER holds bench_cae and, where it was built, bench_onednn."""
import json
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
PYTHON = "/usr/bin/python3"


def environment():
    core = "SKYLAKEX" if " avx512f " in open("/proc/cpuinfo").read() else "HASWELL"
    return {"OPENBLAS_CORETYPE": core, **os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def lines(command, optional=False):
    done = subprocess.run(command, env=environment(), stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE if optional else None, text=True)
    if done.returncode != 0 and not optional:
        sys.exit(done.returncode)
    return [json.loads(line) for line in done.stdout.splitlines()]


def show(rows):
    peak = {row["isa"]: row["gflops"] for row in rows if row["part"] == "peak"}
    print("one core, processor milliseconds an image, medians; `roofline`: the convolutions alone at the peak of this run,")
    print("`flight` as 4x4 convolutions of stride 2; `least`: with the mean taken first, as they are computed\n")
    print("what      layout  isa       GFLOP/s       ms  roofline  ratio    least  ratio")
    for row in rows:
        if row["part"] in ("encode", "training"):
            print(f"{row['part']:9s} {row['layout']:7s} {row['isa']:8s} {peak[row['isa']]:8.0f} {row['ms']:8.3f} "
                  f"{row['roofline_ms']:9.3f} {row['ms'] / row['roofline_ms']:6.2f} {row['least_ms']:8.3f} "
                  f"{row['ms'] / row['least_ms']:6.2f}")
    for row in rows:
        if row["part"] == "encode":
            print(f"of encode {row['layout']:7s} {row['isa']:8s} preprocessing {row['preprocess_ms']:.3f} ms, {row['projecting_ms']:.3f} "
                  "with four images projected out" +
                  (f"; latents moved by {row['latent_moved_sigma']:.1e} sigma" if row["layout"] == "flight" else ""))
    best = {(row["part"], row["layout"]): row["ms"] for row in reversed(rows) if row["part"] in ("encode", "training")}
    for row in rows:
        if row["part"] == "tied":
            print(f"\ntied training of the chapter's scene: {row['steps']} steps, cosine {row['cosine']:.4f}, "
                  f"{row['seconds']:.2f} s by the clock")
        if row["part"] == "agreement":
            print(f"\n{row['layout']}: largest difference from PyTorch over the largest value: latent {row['latent']:.1e}, "
                  f"output {row['output']:.1e}, gradient of any tensor {row['gradient']:.1e}")
        if row["part"] == "peer":
            text = f"{row['peer']:36s} {row['layout']:7s}"
            for what in ("encode", "training"):
                if what + "_ms" in row:
                    ms = row[what + "_ms"]
                    text += f"  {what} {ms:7.3f} ms, {ms / best[what, row['layout']]:.2f} times ours"
            print(text)


def main():
    folder, result = sys.argv[1:]
    with tempfile.TemporaryDirectory() as scratch:
        rows = lines([os.path.join(folder, "bench_cae"), scratch])
        rows += lines([PYTHON, os.path.join(HERE, "torch_cae.py"), scratch], optional=True)
    onednn = os.path.join(folder, "bench_onednn")
    if os.path.exists(onednn):
        rows += lines([onednn], optional=True)
    json.dump(rows, open(result, "w"), indent=1)
    show(rows)


main()
