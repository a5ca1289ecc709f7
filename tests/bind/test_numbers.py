"""Tests that Fortran and Python give the same numbers to the last bit; also failures in Fortran."""
import json
import os
import re
import struct
import subprocess
import tempfile
import unittest

import numpy

from package import ROOT, toliman
from toliman import _raw

KEPT = tempfile.TemporaryDirectory()
SCENE = os.path.join(KEPT.name, "scene.json")
PROGRAMS = os.path.dirname(os.environ["TOLIMAN"])
N, FRAMES = 1095, 6


def setUpModule():
    """The chapter's scene with frames that are not square, so that exchanged rows and columns are detected."""
    unittest.addModuleCleanup(KEPT.cleanup)
    scene = json.loads((ROOT / "examples" / "scenes" / "chapter.json").read_text())
    scene["detector"]["shape"] = [260, 270]
    scene["telescope"]["pupil_samples"] = 80
    scene["band"]["step_nm"] = (scene["band"]["max_nm"] - scene["band"]["min_nm"]) / 4
    with open(SCENE, "w", encoding="utf-8") as stream:
        json.dump(scene, stream)


def run(program, *arguments):
    """(code, stdout, stderr); one OpenBLAS thread, since the last bits of components depend on the number of
    threads."""
    done = subprocess.run([os.path.join(PROGRAMS, program), SCENE, *arguments], universal_newlines=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
    return done.returncode, done.stdout, done.stderr


def value_of(bits):
    return struct.unpack(">d", bytes.fromhex(bits))[0]


def samples():
    k = numpy.arange(N)
    return k * 37 % 101 / 1010 + numpy.where(k % 365 < 182, 0.25, 0)


def least_squares(frequency):
    """Share of the samples' sum of squares that a sinusoid of this frequency removes."""
    y, angle = samples(), 2 * numpy.pi * frequency * numpy.arange(N)
    _, left, _, _ = numpy.linalg.lstsq(numpy.stack([angle * 0 + 1, numpy.cos(angle), numpy.sin(angle)], 1), y, rcond=None)
    return 1 - left[0] / numpy.sum((y - y.mean()) ** 2)


def grid():
    """The lowest frequencies of the grid, which include the highest peak."""
    return [(1.5 + 0.1 * k) / N for k in range(100)]


class Lines(list):
    """What numbers.f90 prints, by the package's classes."""

    def show(self, **values):
        self.extend(f"{name} {struct.pack('>d', float(value)).hex().upper()}" for name, value in values.items())

    def all(self):
        simulator = toliman.Simulator(SCENE)
        info = simulator.info
        self.append(f"version {toliman.__version__}")
        self.show(rows=info.rows, crb=simulator.bounds.crb_px, photons=info.total_photons)
        self.append(f"name {info.name}")
        frame = self.simulate(simulator)
        self.encode(simulator, frame)
        self.follow(simulator, frame)
        self.fit_linear(simulator, frame)
        made = toliman.design_mask(simulator, iterations=1)
        self.show(mask_crb=made.places[0].crb_px, mask_peak_to_mean=made.places[0].peak_to_mean,
                  mask_iterations=made.places[0].iterations, mask_json=len(json.dumps(made.mask)))
        self.search()
        self.find_planets()
        self.track(simulator)
        return self

    def simulate(self, simulator):
        self.show(expect=simulator.expect(1e-6)[120, 100], star_a=simulator.image("star_a")[120, 100],
                  jitter_xy=simulator.derivative("jitter_xy")[120, 100], parameters=len(toliman.parameters()),
                  frames=simulator.frames(5, 2, seed=3)[1][130, 100])
        times, displacements = simulator.series(8, 3)
        frame = simulator.frame(7, displacement=1e-6, seed=3)
        self.show(time=times[2], displacement=displacements[2], offset=simulator.offsets()[1][0], frame=frame[130, 100],
                  frame_sum=numpy.add.accumulate(frame.ravel())[-1])
        return frame

    def encode(self, simulator, frame):
        made, calls = toliman.CAE(simulator, seed=5), []
        loss = made.train(steps=3, progress=lambda stage, fraction: calls.append(stage)).loss
        content = made.to_bytes()
        network = toliman.CAE.from_bytes(content)
        latent, goodness = network.encode(frame, goodness=True)
        self.show(loss=loss, calls=len(calls), bytes=len(content), latent=latent, chi_square=goodness.chi_square,
                  decode=network.decode(1e-3)[3, 250], mmse=network.reconstruct(frame).mmse)

    def follow(self, simulator, frame):
        fit, options = toliman.Fit(simulator, capture_px=1), {"places": 2, "steps": 2}
        made = toliman.Bank(fit, **options)
        made.train()
        content = made.to_bytes()
        bank = toliman.Bank.from_bytes(content, fit)
        result, fitted = bank.encode_frame(frame)
        self.show(networks=toliman.Bank.plan(simulator, **options).networks, bank_bytes=len(content), cosine=bank.networks[3].cosine,
                  bank_displacement=result.displacement_px, bank_sigma=result.sigma_px, fitted=fitted.displacement_px,
                  bank_efficiency=bank.predict().efficiency)

    def fit_linear(self, simulator, frame):
        template, components = toliman.Template(simulator), toliman.Components(simulator)
        for k in range(FRAMES):
            components.push(simulator.frame(k, displacement=1e-3 * k, seed=3))
        components.train()
        values, share = components.series(0)
        self.show(estimate=template.encode(frame), sigma=template.sigma, component=values[2], share=share)

    def search(self):
        t, y = numpy.arange(float(N)), samples()
        grid = {"f0": 1.5 / N, "df": 0.1 / N, "nf": 5461}
        periodogram = toliman.Periodogram(**grid)
        periodogram.push(t[0], y[0])
        periodogram.push_many(t[1:], y[1:])
        peak = periodogram.peak()
        self.show(period=peak.period, log10_fap=peak.log10_fap, period_error=periodogram.fit(t, y).period_error,
                  power=periodogram.power()[102], batch=toliman.batch(t, y, **grid)[102],
                  amplitude=periodogram.model(15).amplitude, second_peak=periodogram.peaks(3)[1].frequency,
                  count=len(toliman.Periodogram.from_bytes(periodogram.to_bytes())))

    def find_planets(self):
        k = numpy.arange(60)
        t, y = 7.0 * k, k * 37 % 101 / 101 + numpy.where(7 * k % 90 < 45, 2, 0)
        found = toliman.planets(t, y, 0.5, rows=(k % 5.0)[:, None], threads=1, period_max=200, samples=100)
        planet = found.candidates[0]
        self.show(planet_candidates=found.info.candidates, planet_residual_rms=found.info.rms, planet_period=planet.period[1],
                  planet_bayes=planet.log10_bayes, planet_sample=found.samples(0, 16)["amplitude"][15],
                  planet_signal=found.signal(0, t)[10], planet_residual=found.residuals()[10],
                  planet_upper=found.limits([70, 150], 0.9)["upper"][1],
                  planet_injected=found.inject((80, 120), (0.6, 0.6), 20))

    def track(self, simulator):
        verdicts = {word: number for number, word in toliman.VERDICTS.items()}
        with toliman.Tracker(toliman.Template(simulator), 1.5 / N, 0.1 / N, 5461, unit_ns=86400e9,
                             clock=[[0, 1000], [10**9, 10**9 + 1000]]) as tracker:
            for k in range(FRAMES):
                pixels = simulator.frame(k, displacement=1e-6, seed=3)
                if k == 3:
                    pixels[7, 9] = numpy.nan
                outcome = tracker.push(toliman.Frame(pixels, k, k * 86400 * 10**9, session="s1", roi="full"))
                self.show(verdict=verdicts[outcome.verdict])
                if k == 3:
                    self.show(bad_pixel=1000 * outcome.row + outcome.col)
            stream, = tracker.streams()
            self.show(tracked=outcome.value, tai=outcome.tai_ns, rejected=tracker.rejected["not_finite"], streams=1,
                      frames=stream.frames)
            self.append(f"session {stream.session}")
            self.show(in_period=len(tracker.period))


class Numbers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.code, cls.printed, cls.errors = run("bind_numbers_fortran")
        cls.lines = [line.split(" ") for line in cls.printed.splitlines()]
        cls.values = {name: value_of(text) for name, text in cls.lines if re.fullmatch("[0-9A-F]{16}", text)}

    def test_fortran_equals_python(self):
        self.assertEqual(self.code, 0, self.errors)
        self.assertGreater(len(self.lines), 40)
        self.assertEqual(self.printed.splitlines(), Lines().all())

    def test_expected_values(self):
        got = self.values
        self.assertEqual(dict(self.lines)["name"], "chapter")
        self.assertEqual(got["rows"], 260)
        self.assertLess(abs(got["estimate"] - 1e-6), 5 * got["sigma"])
        self.assertLess(abs(got["frame_sum"] - got["photons"]), 5 * got["photons"] ** 0.5)
        self.assertAlmostEqual(got["power"], least_squares((1.5 + 0.1 * 102) / N), delta=1e-12)
        self.assertAlmostEqual(got["batch"], got["power"], delta=1e-9)
        self.assertAlmostEqual(least_squares(1 / got["period"]) / max(map(least_squares, grid())), 1, delta=1e-2)
        self.assertAlmostEqual(got["planet_period"], 90, delta=2)
        self.assertGreater(got["planet_bayes"], 2)
        self.assertGreater(got["planet_injected"], 0)
        self.assertEqual(got["networks"], 4)
        self.assertTrue(0 < got["bank_efficiency"] <= 1)
        self.assertLess(abs(got["bank_displacement"] - 1e-6), 5 * got["bank_sigma"])
        self.assertGreater(got["share"], 0.9)  # of frames each displaced by 1000 sigma
        self.assertEqual([got[name] for name in ("count", "in_period", "rejected", "bad_pixel")], [N, FRAMES - 1, 1, 7009])
        self.assertEqual(got["tai"], (FRAMES - 1) * 86400e9 + 1000)


class Failures(unittest.TestCase):
    def test_stat_and_errmsg(self):
        code, output, errors = run("bind_failures")
        self.assertEqual(code, 0, errors)
        lines = output.splitlines()
        expected = [
            (_raw.TOLIMAN_E_NOT_FOUND, "no/such/scene.json"), (_raw.TOLIMAN_E_ARGUMENT, "sim"),
            (_raw.TOLIMAN_E_ARGUMENT, "size(image, 2) = 259: must be 260"), (_raw.TOLIMAN_E_ARGUMENT, "stride"),
            (_raw.TOLIMAN_E_ARGUMENT, "size(weight_b, 1) = 4: must be 5"), (_raw.TOLIMAN_E_NOT_FOUND, "no/such/weights"),
            (_raw.TOLIMAN_E_ARGUMENT, "cae"), (_raw.TOLIMAN_E_ARGUMENT, "pixels is NULL"), (_raw.TOLIMAN_E_ARGUMENT, "f0"),
            (_raw.TOLIMAN_E_STATE, "five samples"), (_raw.TOLIMAN_E_ARGUMENT, "size(y, 1) = 4: must be 5"),
            (_raw.TOLIMAN_E_NOT_FOUND, "no/such/folder"), (_raw.TOLIMAN_OK, "untouched"),
        ]
        self.assertEqual(len(lines), len(expected), output)
        for line, (status, words) in zip(lines, expected):
            self.assertEqual(int(line.split(" ", 1)[0]), status, line)
            self.assertIn(words, line)

    def test_without_stat_the_program_stops(self):
        code, output, errors = run("bind_failures", "stop")
        self.assertNotEqual(code, 0)
        self.assertEqual(output, "")
        self.assertIn("period", errors)

    def test_objects_cannot_be_assigned(self):
        code, output, errors = run("bind_failures", "assign")
        self.assertNotEqual(code, 0)
        self.assertEqual(output, "empty ones may\n")

    @unittest.skipIf(os.environ.get("TOLIMAN_SANITIZE"), "sanitizers keep what is freed")
    def test_memory_is_freed(self):
        """8 times three objects of 13 MB: 0.3 GB if they leaked."""
        child = subprocess.Popen([os.path.join(PROGRAMS, "bind_failures"), SCENE, "leak"], stdout=subprocess.PIPE)
        output = child.stdout.read()
        _, code, usage = os.wait4(child.pid, 0)
        child.stdout.close()
        child.returncode = code
        self.assertEqual((code, output), (0, b"freed\n"))
        self.assertLess(usage.ru_maxrss, 200 * 1024)


if __name__ == "__main__":
    unittest.main()
