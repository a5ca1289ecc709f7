"""Time of a frame of 128 x 128 px that is registered, tested and added, on one core, compared with reading it from memory."""
import os

from measuring import SHORT, lines, row

WHAT = {"jitter": "add a frame of 128 x 128 px, pointing jitter of 0.3 px rms, 1 % with cosmic rays",
        "still": "add a frame of 128 x 128 px, without jitter"}


def measure(binaries):
    return lines([os.path.join(binaries, "bench_coadd"), 300 if SHORT else 2000])


def rows(measured):
    for one in measured:
        if one["part"] == "coadd":
            yield row("coadd", one["what"], WHAT[one["what"]], one["seconds"], one["spread"], roofline=one["roofline"],
                      headline=True, at=f"{one['frames']} frames, {one['added']} added")


def show(measured):
    for one in measured:
        if one["part"] == "coadd":
            print(f"{WHAT[one['what']]}: {1e6 * one['seconds']:.1f} us, {1 / one['seconds']:.0f} frames/s, "
                  f"{one['seconds'] / one['roofline']:.1f} times the reading of the frame")
