"""The same frames in every form in which the mission's image services write them, by numpy, netCDF4 and astropy, and by simulate
--rate: every command reads the same pixels, times, ids and places, and simulate's files are those of the service."""
import gzip
import json
import unittest

import numpy
from test_stream import FORMS, SCENE, SIDE, StreamTest, fits, netCDF4, toliman

FRAMES, STEP = 12, 2 * 10**7
WINDOW = (31, 940)  # row and column of the first pixel, where a form tells them


class Forms(StreamTest):
    """write_...(folder, frames): 12 frames with ids 0 ... 11, 20 ms apart, 3 ns late as no clock of the camera is."""

    def times(self):
        return [k * STEP + 3 for k in range(FRAMES)]

    def write_pair(self, folder, frames, name="obs"):
        frames.astype("<u2").tofile(folder / f"{name}_frames.bin")
        lines = [{"frame_id": k, "timestamp_ns": time, "host_time": k / 50, "nframes_dropped": 0, "roi_label": "centre",
                  "n_rows": SIDE, "n_cols": SIDE, "session_id": "obs"} for k, time in enumerate(self.times())]
        (folder / f"{name}_meta.jsonl").write_text("\n\n".join(map(json.dumps, lines)) + "\n")  # with blank lines

    def write_pair_of_region(self, folder, frames):
        self.write_pair(folder, frames, "obs_centre")

    def write_batches(self, folder, frames):
        for number in range(2):
            part = slice(6 * number, 6 * number + 6)
            self.write_netcdf(folder / f"obs_batch{number:04}.nc", frames[part], numpy.diff(frames[part], axis=0), {
                "timestamp_ns": ("i8", self.times()[part]), "frame_id": ("i8", numpy.arange(FRAMES)[part]),
                "host_time": ("f8", numpy.arange(FRAMES)[part] / 50), "nframes_dropped": ("i4", numpy.zeros(6, int))})

    def write_bulk(self, folder, frames):
        self.write_netcdf(folder / "obs.nc", frames, frames[1:] - frames[0], {}, "ref_core", "diff_core")

    def write_netcdf(self, path, frames, steps, columns, reference="centre_reference", differences="centre_differences"):
        with netCDF4.Dataset(path, "w") as out:
            for name, length in (("row", SIDE), ("col", SIDE), ("step", len(steps)), ("frame", len(frames))):
                out.createDimension(name, length)
            out.createVariable(reference, "u2", ("row", "col"), zlib=True, complevel=5)[:] = frames[0]
            made = out.createVariable(differences, "i2", ("step", "row", "col"), zlib=True, complevel=5)
            made[:] = steps
            made.scale_factor = 1.0
            out[reference].valid_max = numpy.uint16(4095)
            for name, (kind, values) in columns.items():
                out.createVariable(name, kind, ("frame",))[:] = values
            out.session_id, out.batch_size, out.conventions = "obs", len(frames), "CF-1.8"
            for k, time in enumerate(self.times() if not columns else []):
                for key, value in self.keys(k, time).items():
                    out.setncattr(f"{k}_{key}", value)

    def keys(self, number, time):
        return {"SEQNUM": number, "CAMTIME": str(time), "XOFF": 912, "YOFF": 4, "CENTR_X": 64 + WINDOW[1] - 912, "CENTR_Y": 64 + WINDOW[0] - 4}

    def write_cores(self, folder, frames):
        for k, time in enumerate(self.times()):
            header = fits.Header({**self.keys(k, time), "COMTIME": "2025-04-08 15:55:45.020529", "EXPOSURE": 5000.0})
            core = fits.CompImageHDU(frames[k].astype("i2"), name="CORE", compression_type="RICE_1")
            side = fits.CompImageHDU(numpy.zeros((72, 24), "i2"), name="SIDELOBES")
            units = [side, core] if k % 2 else [core, side]
            whole = folder / "whole.fits"
            fits.HDUList([fits.PrimaryHDU(header=header), *units]).writeto(whole)
            (folder / f"frame_proc_{time}.fits.gz").write_bytes(gzip.compress(whole.read_bytes()))
            whole.unlink()

    def write_raw(self, folder, frames):
        for k, time in enumerate(self.times()):
            image = fits.CompImageHDU(frames[k].astype("u2"), header=fits.Header({**self.keys(k, time), "EXPOSURE": 5000.0}))
            fits.HDUList([fits.PrimaryHDU(), image]).writeto(folder / f"frame_{time}.fits")

    FORMS = {"pair": "pair", "pair_of_region": "pair", "batches": "netcdf", "bulk": "netcdf", "cores": "fits", "raw": "fits"}

    def forms(self):
        return [name for name, kind in self.FORMS.items() if kind in FORMS]

    def made(self, name, frames):
        (self.folder / name).mkdir()
        getattr(self, f"write_{name}")(self.folder / name, frames)
        return (name, "--dtype", "u16le") if name.startswith("pair") else (name,)

    def test_every_command_reads_every_form(self):
        self.stream("in", "--jitter", "0.3:5", duration="0.24s")
        frames = self.pair("in")[0].astype(int)
        found = {}
        for name in self.forms():
            with self.subTest(name):
                inputs = self.made(name, frames)
                self.check_sum(name, inputs, frames)
                found[name] = self.results(name, inputs)
                self.assertEqual(found[name], found["pair"])
        kinds = [name for name in ("pair", "bulk", "raw") if name in found]  # a file of each kind
        fitted = [self.calibrated(name, (name, *(("--dtype", "u16le") if name == "pair" else ()))) for name in kinds]
        self.assertEqual(fitted, [fitted[0]] * len(kinds))

    def check_sum(self, name, inputs, frames):
        done = self.run_program("coadd", "--fit", "s.json", "--out", f"{name}_sum", *inputs)
        self.assertEqual(done.returncode, 0, done.stderr)
        line = json.loads((self.folder / f"{name}_sum/sums_meta.jsonl").read_text())
        numpy.testing.assert_array_equal(numpy.fromfile(self.folder / f"{name}_sum/sums_frames.bin", "<u4"), frames.sum(0).ravel())
        self.assertEqual([line["frames"], line["timestamp_ns"] + round(1e9 * line["on_target_s"][0])], [FRAMES, 3])

    def results(self, name, inputs):
        """Of track and encode."""
        done = self.run_program("track", "--fit", "s.json", "--mission-days", "10", "--state", f"{name}_state", *inputs)
        self.assertEqual(done.returncode, 0, done.stderr)
        with toliman.Tracker.open(self.folder / f"{name}_state") as tracker:
            records = numpy.sort(tracker.records(), order="frame_id")
        windows = WINDOW if name in ("bulk", "cores", "raw") else (0, 0)
        self.assertEqual({(row, col) for row, col in zip(records["window_row"], records["window_col"])}, {windows})
        tracked = [(int(r["frame_id"]), int(r["camera_ns"]), float(r["value"]), float(r["exposure_s"])) for r in records]
        self.assertEqual([row[:2] for row in tracked], [(k, time + 2500000) for k, time in enumerate(self.times())])
        rows = [line.split(",")[2:] for line in self.succeed("encode", "--fit", "s.json", *inputs).splitlines()[1:]]
        return tracked, sorted(rows)

    def calibrated(self, name, inputs):
        done = self.run_program("calibrate", "s.json", "--free", "focus", "--out", f"{name}.json", *inputs)
        self.assertEqual(done.returncode, 0, done.stderr)
        fitted = json.loads((self.folder / f"{name}.json").read_text())["telescope"]["aberrations"]
        return {key: numpy.round(value, 9) for key, value in fitted["zernike_rms_nm"].items()}

    def test_simulated_files(self):
        """Those of each format have the pixels, ids and times of the pair, for independent readers."""
        events = ("--jitter", "0.3:5", "--drops", "0.1:3", "--restarts", "4s", "--cosmic-rays", "1")
        self.stream("pair", *events, duration="6s")
        pixels, lines = self.pair("pair")
        expected = [(line["frame_id"], line["timestamp_ns"], line["host_time"], line["nframes_dropped"]) for line in lines]
        for form in FORMS[1:]:
            with self.subTest(form):
                self.stream(form, *events, "--format", form, duration="6s")
                frames, numbers = getattr(self, f"read_{form}")(self.folder / form)
                numpy.testing.assert_array_equal(frames, pixels)
                self.assertEqual(numbers, expected if form == "netcdf" else [row[:2] for row in expected])
                self.assertEqual((self.folder / form / "night_truth.csv").read_text(), (self.folder / "pair/night_truth.csv").read_text())

    def read_netcdf(self, folder):
        frames, numbers = [], []
        for path in sorted(folder.glob("night_batch*.nc")):
            with netCDF4.Dataset(path) as batch:
                batch.set_auto_maskandscale(False)
                self.assertEqual((batch.session_id, batch.batch_size, batch["centre_differences"].scale_factor), ("night", 50, 1))
                self.assertIn(batch["centre_differences"].dtype, (numpy.int8, numpy.int16))
                steps = batch["centre_differences"][:].astype(int)
                frames.extend(batch["centre_reference"][:] + numpy.cumsum(numpy.concatenate([0 * steps[:1], steps]), 0))
                columns = [batch[name][:].tolist() for name in ("frame_id", "timestamp_ns", "host_time", "nframes_dropped")]
                numbers += [(a, b, round(c, 9), d) for a, b, c, d in zip(*columns)]
        return frames, numbers

    def read_fits(self, folder):
        rows = []
        for path in folder.glob("frame_proc_*.fits.gz"):
            with fits.open(path) as file:
                header = file[0].header
                self.assertEqual(path.name, f"frame_proc_{header['CAMTIME']}.fits.gz")
                self.assertEqual((header["EXPOSURE"], file["CORE"]._bintable.header["ZCMPTYPE"] if hasattr(file["CORE"], "_bintable")
                                  else file["CORE"]._header["ZCMPTYPE"]), (5000, "RICE_1"))
                rows.append((header["SEQNUM"], int(header["CAMTIME"]), file["CORE"].data.astype(int)))
        restarted = lambda row: row[1] % 10**7 > 0  # the clock begins 1 us after 0
        rows.sort(key=lambda row: (restarted(row), row[0]))
        return [row[2] for row in rows], [row[:2] for row in rows]


del StreamTest
if __name__ == "__main__":
    unittest.main()
