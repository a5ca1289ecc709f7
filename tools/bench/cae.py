"""Times of the autoencoder on one core, compared with the processor's peak and, where installed, PyTorch and oneDNN."""
import os
import tempfile

from measuring import lines, peer_lines, peer_program, row


def measure(binaries):
    with tempfile.TemporaryDirectory() as scratch:
        found = lines([os.path.join(binaries, "bench_cae"), scratch])
        found += peer_lines("PyTorch", "torch_cae.py", scratch)
    return found + peer_program("oneDNN", [os.path.join(binaries, "bench_onednn")])


def best_of(measured):
    """Milliseconds with the widest instruction set, which comes first."""
    return {(one["part"], one["layout"]): one["ms"] for one in reversed(measured) if one["part"] in ("encode", "training")}


def fastest_peer(measured, what, layout):
    times = [(one[what + "_ms"] / 1e3, one["peer"].split(",")[0]) for one in measured
             if one["part"] == "peer" and one["layout"] == layout and what + "_ms" in one]
    return min(times, default=(None, None))


def rows(measured):
    best = best_of(measured)
    agreement = {(one["layout"], one["isa"]): one for one in measured if one["part"] == "agreement"}
    for one in measured:
        if one["part"] not in ("encode", "training"):
            continue
        what, layout = one["part"], one["layout"]
        reference_seconds, reference = fastest_peer(measured, what, layout)
        error = agreement.get((layout, one["isa"]), {}).get("latent" if what == "encode" else "gradient")
        text = "encode a frame" if what == "encode" else f"training step of {one['batch']} images, per image"
        yield row(what, f"{layout}, {one['isa']}", f"{text}, {layout}, {one['isa']}", one["ms"] / 1e3,
                  one["spread_ms"] / 1e3, error, "of largest", reference, reference_seconds, one["roofline_ms"] / 1e3,
                  one["ms"] == best[what, layout], "one image")
        if what == "encode" and one["ms"] == best[what, layout]:
            for nuisances, ms in one["projection_ms"].items():
                yield row("projection", f"{layout}, {nuisances}", f"{nuisances} nuisances projected out of a frame of many, {layout}, "
                          f"{one['isa']}: encode with minus without", ms / 1e3, headline=nuisances in ("4", "20"))
    for one in measured:
        if one["part"] == "template":
            yield row("encode", "template", "encode a frame, template 256x256", one["ms"] / 1e3, one["spread_ms"] / 1e3,
                      headline=True)
        if one["part"] == "tied":
            yield row("whole training", "tied", "train for the chapter's scene, wall time", one["seconds"], None,
                      1 - one["cosine"], "(1 - cosine)", headline=True)


def show(rows):
    peak = {row["isa"]: row["gflops"] for row in rows if row["part"] == "peak"}
    print("one core, processor milliseconds per image, medians; `roofline`: the products of the convolutions alone (mean taken")
    print("first, or Winograd's form, as computed), at the peak of this run\n")
    print("what      layout  isa       GFLOP/s       ms roofline  ratio")
    for row in rows:
        if row["part"] in ("encode", "training"):
            print(f"{row['part']:9s} {row['layout']:7s} {row['isa']:8s} {peak[row['isa']]:8.0f} {row['ms']:8.3f} "
                  f"{row['roofline_ms']:8.3f} {row['ms'] / row['roofline_ms']:6.2f}")
    for row in rows:
        if row["part"] == "encode":
            more = ", ".join(f"{ms:.3f} ms with {nuisances}" for nuisances, ms in row["projection_ms"].items())
            print(f"of encode {row['layout']:7s} {row['isa']:8s} preprocessing {row['preprocess_ms']:.3f} ms; images projected "
                  f"out cost {more} of them" +
                  (f"; latents differ by {row['latent_moved_sigma']:.1e} sigma" if row["layout"] != "paper" else ""))
    best = best_of(rows)
    for row in rows:
        if row["part"] == "tied":
            print(f"\ntied training of the chapter's scene: {row['steps']} steps, cosine {row['cosine']:.4f}, "
                  f"{row['seconds']:.2f} s wall time")
        if row["part"] == "agreement":
            print(f"{row['layout']}, {row['isa']}: largest difference from PyTorch over the largest value: latent {row['latent']:.1e}, "
                  f"output {row['output']:.1e}, gradient of any tensor {row['gradient']:.1e}")
        if row["part"] == "peer":
            text = f"{row['peer']:36s} {row['layout']:7s}"
            for what in ("encode", "training"):
                if what + "_ms" in row:
                    ms = row[what + "_ms"]
                    text += f"  {what} {ms:7.3f} ms, speed-up {ms / best[what, row['layout']]:.2f}"
            print(text)
