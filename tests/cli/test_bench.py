"""make bench: refuses OpenBLAS kernels that are too old for the processor, and computes its rows from made-up
measurements as expected."""
import contextlib
import io
import json
import os
import pathlib
import platform
import subprocess
import sys
import unittest
import unittest.mock

import schemas
from program import PROGRAM, ROOT, ProgramTest, long

BENCH = ROOT / "tools" / "bench"
sys.path.append(str(BENCH))
import bench
import cae
import calibrate
import commands
import fit
import growth
import measuring
import period
import record
import sim
import size
import table
import weights


class Bench(ProgramTest):
    @unittest.skipUnless(platform.machine() == "x86_64", "kernels are named on x86-64 only")
    def test_refuses_old_kernels(self):
        binaries = pathlib.Path(PROGRAM).parent
        done = subprocess.run(["/usr/bin/python3", BENCH / "bench.py", binaries, "out", "size"], cwd=self.folder,
                              env={**os.environ, "OPENBLAS_CORETYPE": "PRESCOTT"}, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertRegex(done.stderr, r"^bench: OpenBLAS runs its Prescott kernels; set OPENBLAS_CORETYPE")
        self.assertEqual(os.listdir(self.folder / "out"), [])

    @long
    def test_file(self):
        done = subprocess.run(["/usr/bin/python3", BENCH / "bench.py", pathlib.Path(PROGRAM).parent, "out", "size"],
                              cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        text = (self.folder / "out" / "size.json").read_text()
        schemas.check(text)
        self.assertIn("\n| load the library and its dependencies, wall time | ", done.stdout)

    def test_ratios(self):
        row = measuring.row("period", "batch", "x", 0.5, 0.1, 1e-9, "of peak", "astropy", 2.0, 0.25)
        self.assertEqual((row["ratio_peer"], row["ratio_roofline"], row["headline"]), (4, 2, False))
        alone = measuring.row("period", "batch", "x", 0.5, reference="astropy", reference_seconds=None)  # not installed
        self.assertEqual([key for key in alone if "peer" in key or "roofline" in key], [])
        unmeasured = measuring.row("period", "batch", "x", 0.5, of="of peak", at="196 pixels")
        self.assertEqual([key for key in unmeasured if "error" in key], [])

    def test_median_and_spread(self):
        self.assertEqual(measuring.median_spread([5, 1, 100, 3, 2]), (3, 1.5))  # 2 to 5 are the middle half
        self.assertEqual(measuring.median_spread([7]), (7, 0))

    def test_table(self):
        row = {"what": "x", "seconds": 2e-3, "spread": 9e-6, "error": 3e-7, "error_of": "of peak", "error_at": "14 frequencies",
               "peer": "numpy", "ratio_peer": 1234.5, "ratio_roofline": 1.5}
        rows = [row, {**row, "what": "y", "spread": 1e-5, "seconds": 2},
                {"what": "z", "seconds": 5e-6, "error": 1e-9, "wall_seconds": 0.25, "memory_bytes": 111661056}]
        rows = [{"headline": True, **one} for one in rows] + [{"what": "details", "seconds": 1, "headline": False}]
        first = {"machine": {"cpu": "A(R)  CPU Processor"}, "rows": rows}
        self.assertEqual(table.markdown([first]).splitlines(), [
            "| what | error | reference | time | speed-up | x roofline |", "|---|---|---|---|---|---|",
            "| x | 3e-07 of peak at 14 frequencies | numpy | 2 ms +- <1% | 1.23e+03 | 1.50 |",
            "| y | 3e-07 of peak at 14 frequencies | numpy | 2 s +- <1% | 1.23e+03 | 1.50 |",
            "| z | 1e-09 |  | 5 us, wall 250 ms, 112 MB |  |  |"])
        # A second machine has columns of its own, and rows that the first lacks.
        other = {"machine": {"cpu": "B"}, "rows": [{**rows[2], "seconds": 7e-6}, {"what": "new", "seconds": 3, "headline": True}]}
        found = table.markdown([first, other]).splitlines()
        self.assertEqual(found[0], "| what | error | reference | A CPU: time | speed-up | x roofline "
                                   "| B: time | speed-up | x roofline |")
        self.assertEqual(found[4:], ["| z | 1e-09 |  | 5 us, wall 250 ms, 112 MB |  |  | 7 us, wall 250 ms, 112 MB |  |  |",
                                     "| new |  |  |  |  |  | 3 s |  |  |"])

    def test_table_of_rms_errors(self):
        row = {"what": "x", "seconds": 2e-3, "error": 1.0234, "error_of": "of sigma, rms", "error_at": "100 frames",
               "error_largest": 2.871, "headline": True}
        found = table.markdown([{"machine": {"cpu": "A"}, "rows": [row]}]).splitlines()
        self.assertEqual(found[2], "| x | 1.02 of sigma, rms, largest 2.9, at 100 frames |  | 2 ms |  |  |")

    def test_documents_are_those_of_the_record(self):
        recorded = json.loads((BENCH / "recorded.json").read_text())
        for one in recorded:
            schemas.check(json.dumps(one))
        for path, text in record.documents(recorded):
            self.assertEqual(pathlib.Path(path).read_text(encoding="utf-8"), text, "run make record")
            for one in recorded:
                self.assertIn(table.processor(one["machine"]), text)
        slower = json.loads((BENCH / "recorded.json").read_text())
        for row in slower[0]["rows"]:
            row["seconds"] *= 3
        for path, text in record.documents(slower):
            self.assertNotEqual(pathlib.Path(path).read_text(encoding="utf-8"), text)
        with self.assertRaisesRegex(SystemExit, "^record: a document has no lines <!-- table of make record"):
            record.with_section("text", recorded, lambda row: True)

    def test_record_keeps_one_other_processor(self):
        def result(cpu, what):
            return {"schema": "toliman-bench/1", "machine": {"cpu": cpu, "date": "2026-01-31", "isa": "avx2"},
                    "rows": [{"what": what, "headline": True}, {"what": "details", "headline": False}], "details": [1]}
        for name in bench.NAMES:
            (self.folder / f"{name}.json").write_text(json.dumps(result("A", name)))
        newest = record.newest(self.folder)
        self.assertEqual([row["what"] for row in newest["rows"]], list(bench.NAMES))
        before = [result("A", "old"), result("B", "x"), result("C", "x")]
        self.assertEqual([one["machine"]["cpu"] for one in record.with_newest(before, newest)], ["A", "B"])
        self.assertIs(record.with_newest(before, newest)[0], newest)
        (self.folder / "cae.json").write_text(json.dumps(result("B", "cae")))
        with self.assertRaisesRegex(SystemExit, "must be the results of make bench on one machine"):
            record.newest(self.folder)
        (self.folder / "cae.json").unlink()
        with self.assertRaisesRegex(SystemExit, "cae.json: is missing: run make bench"):
            record.newest(self.folder)

    def test_times_below_their_bound(self):
        right, wrong = ({"what": what, "ratio_roofline": ratio} for what, ratio in (("x", 1.0), ("y", 0.94)))
        self.assertEqual(bench.split([right, wrong, {"what": "z"}]),
                         ([right, {"what": "z"}], ["bench: y: takes 0.94 of its lower bound: the bound is wrong"]))

    def test_measures_on_one_core(self):
        script = "import json, os; print(json.dumps(len(os.sched_getaffinity(0))))"
        self.assertEqual(measuring.lines(["/usr/bin/python3", "-c", script]), [1])
        self.assertEqual(measuring.lines(["/usr/bin/python3", "-c", script], one_core=False), [len(os.sched_getaffinity(0))])
        for cores, allowed in ((None, os.sched_getaffinity(0)), (1, {max(os.sched_getaffinity(0))})):
            done = commands.timed(["/usr/bin/python3", "-c", "import os; print(os.sched_getaffinity(0))"], self.folder, cores)
            self.assertEqual(done["out"], f"{allowed}\n")

    def test_unknown_name(self):
        done = subprocess.run(["/usr/bin/python3", BENCH / "bench.py", "bin", "out", "size", "foo"], cwd=self.folder,
                              capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr),
                         (2, "", "bench: unknown benchmark foo: must be one of sim, cae, period, weights, fit, coadd, calibrate, python, commands, growth, size\n"))

    def check_rows(self, module, measured):
        """Rows by their `what`, after a check against the schema."""
        rows = list(module.rows(measured))
        facts = {"date": "2026-01-31", "cpu": "x", "isa": "avx2", "blas_core": "Zen", "fftw": "3"}
        schemas.check(json.dumps({"schema": "toliman-bench/1", "machine": facts, "rows": rows, "details": measured}))
        return {row["what"]: row for row in rows}

    def expect(self, row, **figures):
        for key, value in figures.items():
            if isinstance(value, float):
                self.assertAlmostEqual(row[key], value, delta=1e-12 * value, msg=key)
            else:
                self.assertEqual(row.get(key), value, key)

    def test_rows_of_sim(self):
        image = {"part": "image", "geometry": "chapter", "pixel_arcsec": 0.2, "nodes": 33, "node_seconds": 0.5,
                 "node_spread": 0.01, "node_error": 1e-10, "node_roofline": 0.25, "seconds": 2, "spread": 0.1,
                 "error": 1e-16, "roofline": 1, "compared": 196, "create_s": 2,
                 "numpy": {"name": "numpy 1", "seconds": 8}}
        choice = {"part": "choices", "engine": "mdft", "samples": 128, "wavelengths": 9, "displacement_px": 1e-6,
                  "seconds": 0.1, "error": 1e-3, "compared": 196}
        poisson = {"part": "poisson", "isa": "avx2", "decades": 5, "ns": 8, "spread_ns": 1, "numpy": {"name": "numpy 1", "seconds": 32e-9}}
        rows = self.check_rows(sim, [image, choice, {**choice, "displacement_px": 1e-2},
                                     {"part": "frames", "seconds_1095": 1.095, "spread_1095": 0.01},
                                     {**poisson, "isa": "baseline"}, poisson, {**poisson, "decades": 0, "numpy": None}])
        self.assertEqual(len(rows), 7)  # neither the slower instruction set nor the other displacement
        self.expect(rows["image of 101 wavelengths, 0.2\"/px, accuracy 1e-9: 33 nodes"], seconds=0.5, error=1e-10,
                    error_of="of peak", error_at="196 pixels", peer="numpy 1", ratio_peer=16.0, ratio_roofline=2.0, headline=True)
        self.expect(rows["image of 101 wavelengths, 0.2\"/px, every wavelength"], error=1e-16, error_at="196 pixels",
                    ratio_peer=4.0, ratio_roofline=2.0)
        self.expect(rows["create a simulator of 101 wavelengths, 0.2\"/px, 33 nodes"], seconds=2, ratio_peer=0.5)
        self.expect(rows["a noisy frame of the chapter's scene, 256 x 256 px"], seconds=1e-3, headline=True)
        self.expect(rows["chapter, 128 pupil samples, 9 wavelengths"], error_at="196 pixels", headline=False)
        self.expect(rows["65,536 Poisson counts of means 1e4 to 1e9"], seconds=8 * 65536e-9, ratio_peer=4.0, headline=True)
        self.expect(rows["65,536 Poisson counts of means 1e4"], peer=None, ratio_peer=None, headline=False)

    def test_rows_of_growth(self):
        of_case = {"processor_s": 1, "spread_s": 0.01, "wall_s": 0.5, "memory_bytes": 10**6}
        measured = [{"case": make.__name__, "size": size, **of_case, "processor_s": 1 + 1e-6 * size**2}
                    for make, _, _, sizes in growth.CASES for size in sizes]
        rows = self.check_rows(growth, measured)
        self.assertEqual(len(rows), len(measured))
        largest = growth.CASES[-1][3][-1]
        self.expect(rows[f"toliman rebuild: {largest:,} frames"], size=largest, seconds=1 + 1e-6 * largest**2, headline=True)
        self.assertEqual(sum(row["headline"] for row in rows.values()), len(growth.CASES))
        for power in (0.5, 1, 2):
            self.assertAlmostEqual(growth.exponent([(size, 3 * size**power) for size in (1, 10, 1000)]), power)
        self.assertAlmostEqual(growth.exponent([(1, 5), (10, 10), (100, 100)]), 1)  # without the smallest

    def test_pareto_front(self):
        choices = [{"seconds": s, "error": e} for s, e in ((1, 1e-3), (2, 1e-6), (3, 1e-6), (4, 1e-5), (5, 1e-9))]
        sim.mark_front(choices)
        self.assertEqual([one["front"] for one in choices], [True, True, False, False, True])

    def test_rows_of_cae(self):
        def measured(isa, ms, roofline_ms):
            encode = {"part": "encode", "isa": isa, "layout": "flight", "ms": ms, "spread_ms": 0.01, "roofline_ms": roofline_ms,
                      "projection_ms": {"4": 0.125, "32": 0.25}}
            return [encode, {**encode, "part": "training", "ms": 10 * ms, "roofline_ms": 8 * roofline_ms, "batch": 16}]
        wide, narrow = measured("avx512", 0.5, 0.25), measured("avx2", 0.75, 0.25)
        peers = [{"part": "peer", "peer": "oneDNN 2.6", "layout": "flight", "encode_ms": 1},
                 {"part": "peer", "peer": "PyTorch 1, default", "layout": "flight", "encode_ms": 2, "training_ms": 20},
                 {"part": "peer", "peer": "PyTorch 1, default", "layout": "paper", "encode_ms": 0.1, "training_ms": 0.1}]
        agreement = [{"part": "agreement", "layout": "flight", "isa": "avx512", "latent": 1e-6, "gradient": 2e-6}]
        tied = {"part": "tied", "seconds": 0.75, "cosine": 0.75}
        template = {"part": "template", "ms": 0.03125, "spread_ms": 0.001}
        rows = self.check_rows(cae, wide + narrow + [tied, template] + agreement + peers)
        self.expect(rows["4 nuisances projected out of a frame of many, flight, avx512: encode with minus without"], seconds=0.125e-3)
        self.assertEqual(len([what for what in rows if what.startswith("4 nuis")]), 1)  # the widest instruction set
        self.expect(rows["encode a frame, template 256x256"], seconds=0.03125e-3)
        self.expect(rows["encode a frame, flight, avx512"], seconds=0.5e-3, spread=1e-5, error=1e-6, error_of="of largest",
                    error_at="one image", peer="oneDNN 2.6", ratio_peer=2.0, ratio_roofline=2.0, headline=True)
        self.expect(rows["training step of 16 images, per image, flight, avx512"], error=2e-6, peer="PyTorch 1", ratio_peer=4.0,
                    ratio_roofline=2.5, headline=True)
        self.expect(rows["encode a frame, flight, avx2"], error=None, error_of=None, ratio_roofline=3.0, headline=False)
        self.expect(rows["train for the chapter's scene, wall time"], seconds=0.75, error=0.25, headline=True)

    def test_rows_of_period(self):
        def on(grid, compared):
            return {"samples": grid[0], "frequencies": grid[1], "compared": compared}
        small, large = on(period.GRIDS[0], 10000), on(period.GRIDS[-1], 14)
        frame = {"part": "frame", "isa": "avx512", "seconds": 4e-5, "spread": 1e-6, "roofline": 2e-5}
        batch = {"part": "batch", "tolerance": 1e-3, "seconds": 0.5, "spread": 0.01, "error": 1e-7}
        astropy = {"part": "astropy", "method": "fast", "version": "5.2", "seconds": 2, "error": 1e-4, **small}
        measured = [{**frame, **small, "isa": "avx2"}, {**frame, **small}, {**batch, **small}, {**batch, **large},
                    {**batch, **large, "tolerance": 1e-6},
                    {"part": "direct", "seconds": 280, "measured": 0.25, "error": 1e-17, **large},
                    {"part": "stream", "seconds": 1, "measured": 1, "error": 1e-16, **small}]
        rows = self.check_rows(period, measured + [astropy])
        of_small, of_large = "1,000 samples, 10,000 frequencies", "1,000,000 samples, 100,000 frequencies"
        self.expect(rows["push one frame, query 10,000 powers, avx512"], peer="astropy 5.2 fast, all 1,000 samples",
                    ratio_peer=50000.0, ratio_roofline=2.0, headline=True, error=1e-16)
        self.expect(rows["push one frame, query 10,000 powers, avx2"], headline=False)
        self.expect(rows[of_small + ", tolerance 0.001"], error=1e-7, error_at=None, ratio_peer=4.0, headline=True)
        self.expect(rows[of_large + ", tolerance 0.001"], error_at="14 frequencies", peer=None, headline=True)
        self.expect(rows[of_large + ", tolerance 1e-06"], headline=False)
        self.expect(rows[of_large + ", direct sums, extrapolated from 0.25"], error=None, error_at=None)
        self.expect(rows[of_small + ", astropy fast"], error=1e-4, error_at=None)
        alone = self.check_rows(period, measured)  # without astropy
        self.assertEqual([row for row in alone.values() if "peer" in row or "ratio_peer" in row], [])
        self.assertEqual(len(alone), len(rows) - 1)

    def test_rows_of_commands(self):
        def of_seed(processor_s, period_days, efficiency):
            return {"part": "run", "processor_s": processor_s, "wall_s": processor_s / 2, "memory_bytes": 1000000,
                    "period_days": period_days, "true_period_days": 400, "efficiency": efficiency, "frames": 100}
        runs = [of_seed(9, 400, 0.9), of_seed(12, 401, 0.7), of_seed(10, 390, 0.8), of_seed(8, 402, 0.6), of_seed(60, 400, 1)]
        simple = [{"part": part, "processor_s": 0.5, "spread_s": 0.25, "wall_s": 0.75}
                  for part in ("psf", "period", "planet", "planets", "simulate", "simulate sky")]
        simple.append({"part": "pupil", "processor_s": 10.0, "spread_s": 0.0, "wall_s": 20.0})
        library = {"part": "library", "case": "template 64x64", "frames": 1000, "threads": 0, "frames_per_wall_s": 40000}
        track = {"part": "track", "case": "template 64x64", "every": 1, "jobs": 1, "sync": "none", "seconds": 5e-5}
        encode = {"part": "encode", "case": "fit 64x64", "cores": 2, "seconds": 25e-5}
        rest = [encode, {**encode, "cores": 1, "seconds": 4e-4}, library, {"part": "library", "case": "encode alone", "frames_per_cpu_s": 1}, track,
                {**track, "sync": "group", "seconds": 1e-4}, {**track, "case": "fit 64x64", "every": 1000, "seconds": 3e-4},
                {"part": "fdatasync", "seconds": 64e-4}]
        numpy = {"part": "numpy", "image": {"name": "numpy 1", "seconds": 0.5}, "poisson": {"name": "numpy 1", "seconds": 1e-8}}
        rows = self.check_rows(commands, runs + simple + rest + [numpy])
        self.assertEqual(len(rows), 14)
        self.expect(rows["toliman simulate sky.json: 1095 frames into a file"], seconds=0.5, wall_seconds=0.75, peer=None)
        self.expect(rows["toliman encode, fit 64x64, 1 core: per frame, wall time"], seconds=4e-4, peer=None, headline=True)
        self.expect(rows["toliman encode, fit 64x64, 2 cores: per frame, wall time"], seconds=25e-5)
        self.expect(rows["toliman track, fit 64x64, --every 1000, --jobs 1, --sync none: per frame, wall time"], seconds=3e-4,
                    peer=None)  # the library's tracker is measured with other estimators
        # numpy: 0.5 s for 101 wavelengths of a star, hence 51 of two stars, 100 frames
        self.expect(rows["toliman run chapter.json"], seconds=10, spread=1.5, wall_seconds=5.0, memory_bytes=1000000,
                    error=1 - 390 / 400, error_at="5 seeds", efficiency=0.8, ratio_peer=0.5 * 102 / 101 * 100 / 10, headline=True)
        self.expect(rows["toliman psf chapter.json"], seconds=0.5, wall_seconds=0.75, peer="numpy 1", ratio_peer=102 / 101)
        self.expect(rows["toliman simulate chapter.json: 1095 frames into a file"], ratio_peer=1e-8 * 65536 * 1095 / 0.5)
        self.expect(rows["toliman pupil chapter.json"], seconds=10, wall_seconds=20)
        self.expect(rows["toliman planet: 836 separations, 5 functions, one planet"], seconds=0.5, wall_seconds=0.75, peer=None)
        what = "toliman track, template 64x64, --every 1, --jobs 1, --sync %s: per frame, wall time"
        self.expect(rows[what % "none"], seconds=5e-5, peer="the library", ratio_peer=0.5)
        self.expect(rows[what % "group"], seconds=1e-4, ratio_peer=(5e-5 + 1e-4) / 1e-4)
        alone = self.check_rows(commands, runs + simple + rest + [{"part": "numpy", "image": None, "poisson": None}])
        self.assertNotIn("peer", alone["toliman psf chapter.json"])
        warning = io.StringIO()
        with contextlib.redirect_stderr(warning):
            rows = self.check_rows(commands, runs + simple + rest + [numpy, {**track, "case": "busy", "seconds": -1e-6},
                                               {**encode, "case": "busy too", "seconds": 0}])
        self.assertEqual(len(rows), 14)
        self.assertIn("toliman encode, busy too: a few frames took longer than all", warning.getvalue())
        self.assertIn("toliman track, busy: a few frames took longer than all: the machine is too busy", warning.getvalue())

    def test_rows_of_fit(self):
        one = {"part": "fit", "what": "0.3", "parameters": 7, "frames": 100, "seconds": 6e-3, "spread": 1e-4, "steps": 4,
               "searched": 0, "rms_pull": 1.1, "largest_pull": 2.5, "roofline": 1e-3}
        image = {"part": "image", "seconds": 1e-3, "spread": 1e-5, "error": 1e-10, "compared": 5, "predicted_error": 7e-10,
                 "taps": 12, "oversampling": 2, "roofline": 2e-4}
        own = [one, {**one, "what": "0.03", "seconds": 4e-3}, {**one, "what": "exact"}, {**one, "what": "free"}, image,
               {"part": "create", "seconds": 0.5}]
        numpy = {"name": "numpy 1, Fourier shifts", "seconds": 30e-3, "steps": 4, "frames": 100, "rms_pull": 1.2,
                 "largest_pull": 3}
        measured = own + [{"part": "numpy", "result": numpy}]
        rows = self.check_rows(fit, measured)
        self.assertEqual(len(rows), 7)
        scene = "fit a frame of sky.json, 256 x 256 px"
        self.expect(rows[scene + ", prediction off by 0.3 px rms"], seconds=6e-3, error=1.1, error_of="of sigma, rms",
                    error_at="100 frames", error_largest=2.5, steps=4, peer="numpy 1, Fourier shifts", ratio_peer=5.0,
                    ratio_roofline=6.0, headline=True)
        self.expect(rows[scene + ", prediction off by 0.03 px rms"], peer="the model image", ratio_peer=0.25)
        self.expect(rows["numpy, Fourier shifts: " + scene + ", prediction off by 0.3 px rms"], seconds=30e-3, error=1.2,
                    error_largest=3, peer=None)
        self.expect(rows["model image of sky.json, 256 x 256 px"], error=1e-10, error_of="of peak",
                    error_at="5 propagated frames", ratio_roofline=5.0)
        self.assertEqual([row["what"] for row in rows.values() if row["what"].startswith(record.MAIN)],
                         [scene + ", prediction off by 0.3 px rms"])
        shown = io.StringIO()
        with contextlib.redirect_stdout(shown):
            fit.show(measured)
        self.assertIn("0.3                          7      4      6.000           6.0      1.100                  2.50", shown.getvalue())
        alone = self.check_rows(fit, own + [{"part": "numpy", "result": None}])  # without numpy
        self.assertEqual(len(alone), 6)
        self.assertNotIn("peer", alone[scene + ", prediction off by 0.3 px rms"])

    def test_rows_of_calibrate(self):
        run = {"processor_s": 12.0, "wall_s": 8.0, "memory_bytes": 500000000}
        measured = {"runs": [run, {**run, "processor_s": 11.0}, {**run, "processor_s": 14.0, "wall_s": 9.0}], "frames": 10,
                    "parameters": 25, "iterations": 6, "verdict": ["converged; the model is complete"], "chi_square": 1.001,
                    "separation_sigma_px": 5e-5, "calibration_sigma_px": 1e-6, "rms_pull": 1.1, "largest_pull": 2.5}
        row, = self.check_rows(calibrate, measured).values()
        self.assertTrue(row["what"].startswith(record.MAIN))
        self.expect(row, what="toliman calibrate sky.json, wavelengths every 27.5 nm: 10 frames, 25 parameters", seconds=12.0,
                    spread=1.5, wall_seconds=8.0, memory_bytes=500000000, error=1.1, error_of="of sigma, rms",
                    error_at="10 frames", error_largest=2.5, steps=6, headline=True)
        shown = io.StringIO()
        with contextlib.redirect_stdout(shown):
            calibrate.show(measured)
        self.assertIn("complete: chi-square 1.0010, 6 iterations, 1.33 s each (wall time)", shown.getvalue())

    def test_scenes_of_calibrate(self):
        nominal, truth = calibrate.nominal_scene(), calibrate.true_scene()
        photons_per_s = sum(star["detected_per_s"] for star in nominal["stars"].values())
        self.assertAlmostEqual(nominal["cadence"]["exposure_s"] * photons_per_s, 1e10, delta=1)
        for path in (("band",), ("cadence",), ("binary",), ("stars",), ("noise",), ("telescope", "mask", "terms")):
            one, other = nominal, truth
            for key in path:
                one, other = one[key], other[key]
            self.assertEqual(one, other)
        self.assertNotEqual(nominal["telescope"], truth["telescope"])

    def test_rows_of_weights_and_size(self):
        one = {"weights": "bf16", "planes": "bf16", "bytes": 1000000, "load_s": 0.01, "load_spread": 0.001, "change": 1e-3,
               "efficiency": 0.9}
        first = {**one, "weights": "float32", "planes": "float32", "change": 0.0}
        rows = self.check_rows(weights, [first, one, {**one, "planes": "fp16"}])
        self.assertNotIn("error", rows["load weights in float32, planes in float32: 1.00 MB"])
        self.expect(rows["load weights in bf16, planes in bf16: 1.00 MB"], seconds=0.01, error=1e-3, bytes=1000000,
                    efficiency=0.9, headline=True)
        self.expect(rows["load weights in bf16, planes in fp16: 1.00 MB"], headline=False)
        rows = self.check_rows(size, {"bytes": 1, "ldd": "", "whole_s": [5, 1, 100, 3, 2], "own_s": [0.5]})
        self.expect(rows["load the library and its dependencies, wall time"], seconds=3, spread=1.5, headline=True)
        self.expect(rows["load the library alone, wall time"], seconds=0.5, headline=False)

    def test_without_astropy(self):
        warning = io.StringIO()
        with contextlib.redirect_stderr(warning), unittest.mock.patch.dict(os.environ, PYTHONPATH=str(self.folder)):
            (self.folder / "astropy.py").write_text("raise ModuleNotFoundError('No module named astropy')")
            for _ in period.GRIDS:
                self.assertEqual(measuring.peer_lines("astropy", "astropy_period.py"), [])
        self.assertEqual(warning.getvalue(), "bench: no reference times from astropy (ModuleNotFoundError: No module named "
                                            "astropy); see tools/bench/README.md\n")  # once

    def test_missing_peers(self):
        warning = io.StringIO()
        with contextlib.redirect_stderr(warning):
            self.assertEqual(measuring.peer_program("oneDNN", ["./not-built"]), [])
            self.assertEqual(measuring.peer_program("PyTorch", ["sh", "-c", "echo 1; echo x >&2; echo no torch >&2; exit 1"]), [])
        self.assertEqual(warning.getvalue(),
                         "bench: no reference times from oneDNN (No such file or directory); see tools/bench/README.md\n"
                         "bench: no reference times from PyTorch (no torch); see tools/bench/README.md\n")
        with self.assertRaises(SystemExit):
            measuring.lines(["false"])


if __name__ == "__main__":
    unittest.main()
