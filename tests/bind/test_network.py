"""Tests networks, templates and components in Python against the program, numpy, and each other."""
import copy
import json
import os
import pathlib
import pickle
import struct
import subprocess
import tempfile
import threading
import unittest
import zlib

import numpy

from package import ROOT, toliman
from refusal import refused
from toliman import _pixels

ROWS, COLS = 260, 270


def setUpModule():
    global simulator, network, frames
    scene = json.loads((ROOT / "examples" / "scenes" / "chapter.json").read_text())
    scene["detector"]["shape"] = [ROWS, COLS]
    scene["telescope"]["pupil_samples"] = 128
    scene["band"]["step_nm"] = (scene["band"]["max_nm"] - scene["band"]["min_nm"]) / 4
    simulator = toliman.Simulator(scene)
    network = toliman.CAE(simulator)
    network.train()
    frames = simulator.frames(0, 12)


class Windows(unittest.TestCase):
    """Frames of the camera's window of 128x128 pixels."""

    @classmethod
    def setUpClass(cls):
        scene = json.loads((ROOT / "examples" / "scenes" / "chapter.json").read_text())
        scene["detector"]["shape"] = [128, 128]
        scene["telescope"]["pupil_samples"] = 128
        scene["band"]["step_nm"] = (scene["band"]["max_nm"] - scene["band"]["min_nm"]) / 4
        cls.simulator = toliman.Simulator(scene)
        cls.network = toliman.CAE(cls.simulator)
        cls.network.train()

    def test_layout(self):
        info = self.network.info
        self.assertEqual((info.layout, info.side, self.network.shape), ("core", 128, (128, 128)))
        self.assertGreater(info.cosine, 0.98)
        for image in (self.network.decode(0), self.network.target(),
                      self.network.reconstruct(self.simulator.frame(0)).image):
            self.assertEqual(image.shape, (128, 128))
        self.assertEqual(toliman.CAE(simulator, layout="core").info.side, 128)
        self.assertEqual(network.info.side, 256)
        with refused(toliman.UnsupportedError, "detector.shape"):
            toliman.CAE(self.simulator, layout="flight")

    def test_windows(self):
        """Without bad pixels they change nothing; without a shape of frames they are refused."""
        frames = self.simulator.frames(0, 3)
        latents = self.network.encode(frames)
        places = numpy.array([[900 + k, 40 - k] for k in range(3)])
        for one in (places, places[0], places.astype("i2").tolist()):
            self.assertTrue((self.network.encode(frames, windows=one) == latents).all())
        self.assertEqual(self.network.encode(frames[1], windows=(3, 4)), latents[1])
        self.assertTrue((toliman.Template(self.simulator).encode(frames, windows=places)
                         == toliman.Template(self.simulator).encode(frames)).all())
        for wrong in (places[:2], places[:, :1], places + 0.5, (1, 2, 3)):
            with self.assertRaisesRegex(ValueError, "windows"):
                self.network.encode(frames, windows=wrong)
        with refused(toliman.InputError, "image->windows"):
            self.network.encode(frames, windows=(0, 2**40))


class Network(unittest.TestCase):
    def test_training_reaches_the_photon_limit(self):
        other = toliman.CAE(simulator, seed=5)
        self.assertFalse(other.info.trained)
        training = other.train(steps=300)
        self.assertEqual((training.steps, training.cosine), (300, other.info.cosine))
        self.assertGreater(training.cosine, 0.98)
        self.assertTrue(other.info.trained)
        self.assertEqual(other.info.layout, "flight")

    # promise: latent-slope-is-stated
    def test_slope_of_the_latent(self):
        step = 1e-5
        latents = network.encode(numpy.stack([simulator.expect(step), simulator.expect(-step)]))
        self.assertAlmostEqual((latents[0] - latents[1]) / (2 * step), 1, delta=1e-3)

    def test_frames_in_any_form(self):
        latents = network.encode(frames)
        self.assertEqual([network.encode(frame) for frame in frames], latents.tolist())
        for same in (frames.astype(">f8"), frames.astype("<u4"), frames.astype(numpy.int64), frames.tolist(),
                     numpy.asfortranarray(frames), numpy.repeat(frames, 2, axis=0)[::2], frames[::-1][::-1]):
            self.assertTrue((network.encode(same) == latents).all())
        self.assertIs(type(network.encode(frames[0])), float)

    def test_every_pixel_type_is_read_in_place(self):
        """Without a copy as doubles, which would need 8 bytes per pixel."""
        counts = (frames[:3] / 1e6).round()
        template = toliman.Template(simulator)
        for type_name in ("u1", "<u2", ">u2", "<u4", ">u4", "<i2", ">i2", "<i4", "<f4", ">f4", "<f8"):
            typed = numpy.minimum(counts, 255 if type_name == "u1" else 1e4).astype(type_name)
            _, lying = _pixels.image_of(typed[:, ::2])
            self.assertTrue(numpy.shares_memory(lying, typed))
            for estimator in (network, template):
                expected = estimator.encode(typed.astype("f8"))
                self.assertEqual(estimator.encode(typed).tolist(), expected.tolist(), type_name)
                self.assertEqual(estimator.encode(typed.transpose(1, 0, 2).copy().transpose(1, 0, 2)).tolist(), expected.tolist())
                self.assertEqual(estimator.encode(typed[2]), expected[2])
        masked = numpy.ma.masked_equal(counts.astype("u2"), 3)
        masked[0, 0, 0] = numpy.ma.masked
        with refused(ValueError, "frames"):
            network.encode(masked)

    def test_chi_square(self):
        """Chi-square is 1 for valid frames and not for others; the template's equals that of numpy's least
        squares."""
        template, damaged = toliman.Template(simulator), frames.copy()
        damaged[1, ::2] = 0
        for estimator, pixels in ((network, 65536), (template, ROWS * COLS)):
            values, fits = estimator.encode(damaged, goodness=True)
            squares = fits["chi_square"]
            with self.assertWarns(toliman.FitWarning):
                self.assertEqual(values.tolist(), estimator.encode(damaged).tolist())
            out = numpy.abs(squares - 1) > 5 * (2 / pixels) ** 0.5
            self.assertEqual(numpy.flatnonzero(out).tolist(), [1])
            value, fit = estimator.encode(damaged[2], goodness=True)
            self.assertEqual((value, fit.chi_square, fit.goodness), (values[2], squares[2], "good"))
        sigma = simulator.image("variance") ** 0.5
        residual = (damaged[1] - simulator.image()) / sigma
        _, left, _, _ = numpy.linalg.lstsq((simulator.image("separation") / sigma).reshape(-1, 1), residual.ravel(), rcond=None)
        self.assertAlmostEqual(squares[1] / (left[0] / (ROWS * COLS - 1)), 1, delta=1e-9)

    def test_no_frames(self):
        self.assertEqual(network.encode(frames[:0]).shape, (0,))

    def test_invalid_frames(self):
        with tempfile.NamedTemporaryFile() as file:
            objects = numpy.memmap(file.name, "u1", "w+", shape=(ROWS, COLS)).astype(object)
            with refused(TypeError, "frames"):
                network.encode(objects)
        for bad in (None, "frame", frames[0].astype("M8[s]"), [object()], frames[0].astype(str)):
            with refused(TypeError, "frames"):
                network.encode(bad)
        with refused(ValueError, "frames"):
            network.encode([numpy.ma.masked_greater(frame, 10) for frame in frames])
        for bad in frames[0].T, frames[0, 0], frames[:, :5]:
            with refused(ValueError, "frames"):
                network.encode(bad)
        hot = frames[0].copy()
        hot[200, 100] = numpy.nan
        with refused(toliman.InputError, "counts[200][100]"):
            network.encode(hot)
        with refused(ValueError, "frames"):
            network.encode(numpy.ma.masked_greater(frames[0], 10))
        with refused(TypeError, "frames"):
            network.encode(frames[0] * 1j)

    def test_saved_and_loaded(self):
        latents = network.encode(frames)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "weights.tlmw"
            network.save(path)
            self.assertEqual(path.read_bytes(), network.to_bytes())
            self.assertTrue((toliman.CAE.load(path).encode(frames) == latents).all())
            frames.astype("<u4").tofile(pathlib.Path(folder) / "frames.bin")
            output = subprocess.run([os.environ["TOLIMAN"], "encode", "--weights", path, "--dtype", "u32le", "--shape",
                                     f"{ROWS}x{COLS}", pathlib.Path(folder) / "frames.bin"], check=True,
                                    capture_output=True, text=True).stdout
        self.assertEqual([float(line.split(",")[2]) for line in output.splitlines()[1:]], latents.tolist())
        self.assertTrue((pickle.loads(pickle.dumps(network)).encode(frames) == latents).all())
        self.assertLess(len(network.to_bytes(weights="fp16", planes="bf16")), 0.7 * len(network.to_bytes()))
        with refused(toliman.InputError):
            toliman.CAE.from_bytes(b"not weights" * 100)
        with self.assertRaises(FileNotFoundError):
            toliman.CAE.load("/nowhere/weights.tlmw")
        with refused(ValueError, "weights"):
            network.to_bytes(weights="int8")

    def test_decoder_output_is_the_target(self):
        target, decoded = network.target(), network.decode(1e-6) / 1e-6
        cosine = (target * decoded).sum() / numpy.sqrt((target**2).sum() * (decoded**2).sum())
        self.assertGreater(cosine, 0.98)
        again = network.reconstruct(frames[0])
        self.assertEqual(again.image.shape, (256, 256))
        self.assertAlmostEqual(again.mmse / again.photon_floor, 1, delta=0.1)

    def test_unsupervised_by_array_or_function(self):
        def part(first, count):
            return frames[first:first + count]
        trained = []
        for source in ({"frames": frames[:6]}, {"frames": part, "count": 6}):
            other = toliman.CAE(simulator, layout="paper", input="raw")
            training = other.train("unsupervised", epochs=2, batch=3, validation=2, **source)
            self.assertEqual((training.epochs, training.steps), (2, 4))
            trained.append(other.to_bytes())
        self.assertEqual(*trained)

    def test_results_of_each_epoch(self):
        """Each is the result of a training of as many epochs; the training stops if the function asks for it."""
        how = {"frames": frames[:6], "batch": 3, "validation": 2}
        seen = []
        other = toliman.CAE(simulator)
        result = other.train("unsupervised", epochs=2, **how,
                             epoch=lambda so_far, training: seen.append((training, so_far.to_bytes(training=True))))
        self.assertEqual((result, other.to_bytes(training=True)), seen[1])
        again = toliman.CAE(simulator)
        self.assertEqual((again.train("unsupervised", epochs=1, **how), again.to_bytes(training=True)), seen[0])
        again = toliman.CAE(simulator)
        with refused(toliman.Cancelled):
            again.train("unsupervised", epochs=2, epoch=lambda so_far, training: training.epochs == 1, **how)
        again.train("unsupervised", epochs=2, **how)
        self.assertEqual(again.to_bytes(), other.to_bytes())

    def test_exceptions_of_a_frame_function_propagate(self):
        other = toliman.CAE(simulator, layout="paper", input="raw")
        before = other.to_bytes()

        def broken(first, count):
            raise ZeroDivisionError("the disk is gone")
        with refused(ZeroDivisionError, "the"):
            other.train("unsupervised", epochs=1, frames=broken, count=8)
        with refused(ValueError, "frames"):
            other.train("unsupervised", epochs=1, frames=lambda first, count: frames[:0], count=8)
        with refused(ValueError, "count"):
            other.train("unsupervised", frames=broken)
        self.assertEqual(other.to_bytes(), before)


    def test_tracker_keeps_its_estimator_alive(self):
        for estimator in (toliman.CAE.from_bytes(network.to_bytes()), toliman.Template(simulator)):
            expected = estimator.encode(frames[1])
            tracker = toliman.Tracker(estimator, 0.01, 0.001, 100)
            with estimator:
                pass
            junk = [numpy.ones((300, 300)) for _ in range(30)]
            self.assertEqual(tracker.push(toliman.Frame(frames[1], 1, 0)).value, expected)
            del junk
            with refused(ValueError, "this"):
                estimator.encode(frames[:0])

    def test_training_while_in_use(self):
        other = toliman.CAE(simulator)
        tracker = toliman.Tracker(other, 0.01, 0.001, 100)
        with refused(RuntimeError, "a"):
            other.train(steps=2)
        tracker.close()
        with refused(RuntimeError, "this"):
            other.train(steps=2, progress=lambda stage, fraction: other.train())
        other.train(steps=2)
        with refused(ValueError, "frames,"):
            other.train(frames=frames)

    def test_closing_during_training(self):
        other = toliman.CAE(simulator)
        self.assertEqual(other.train(steps=3, progress=lambda stage, fraction: other.close()).steps, 3)
        thread = threading.Thread(target=simulator.frames, kwargs={"count": 200})
        copy = toliman.CAE(simulator)
        thread = threading.Thread(target=copy.encode, args=(numpy.repeat(frames, 5, axis=0),))
        thread.start()
        copy.close()
        thread.join()

    def test_crop_that_follows_the_image(self):
        """A frame moved by whole pixels has the latent of the frame itself, also on a bright background."""
        scene = json.loads((ROOT / "examples" / "scenes" / "chapter.json").read_text())
        scene["detector"].update(shape=[ROWS, COLS], dark_e_per_s=1e9)
        scene["cadence"] = {"frames": 1095, "interval_days": 1, "exposure_s": 1}
        for star, photons in zip(scene["stars"].values(), (8e10, 2.6e10)):
            del star["relative_flux"]
            star["photons_per_s"] = photons
        scene["telescope"]["pupil_samples"] = 128
        scene["band"] = {"wavelength_nm": 580}
        simulated = toliman.Simulator(scene)
        frames = simulated.frames(0, 2).astype("<u8")
        for options in ({}, {"layout": "paper", "input": "raw"}):
            fixed, following = (toliman.CAE(simulated, centre=centre, **options) for centre in ("scene", "image"))
            self.assertEqual((fixed.info.centre, following.info.centre), ("scene", "image"))
            latents, fits = following.encode(frames, goodness=True)
            self.assertEqual(latents.tolist(), fixed.encode(frames).tolist())
            for shift in ((1, -5), (-2, 6), (0, 0)):
                moved = numpy.roll(frames, shift, axis=(1, 2))
                again, found = following.encode(moved, goodness=True)
                self.assertEqual((again.tolist(), found.tolist()), (latents.tolist(), fits.tolist()))
                self.assertEqual((fixed.encode(moved) == latents).all(), shift == (0, 0))
                self.assertTrue((following.reconstruct(moved[0]).image == following.reconstruct(frames[0]).image).all())
            loaded = toliman.CAE.from_bytes(following.to_bytes())
            self.assertEqual((loaded.info, loaded.to_bytes()), (following.info, following.to_bytes()))
            self.assertEqual(loaded.encode(moved).tolist(), latents.tolist())
        self.assertNotEqual(following.encode(numpy.roll(frames[0], 9, axis=1)), latents[0])  # stays within the frame
        damaged = frames[0].astype(float)
        damaged[9, 30] = numpy.nan
        with refused(toliman.InputError, "counts[9][30]"):
            following.encode(damaged)
        with refused(toliman.InputError, "counts"):
            following.encode(numpy.zeros((ROWS, COLS)))
        scene["detector"]["shape"] = [256, 256]
        with refused(toliman.UnsupportedError, "detector.shape"):
            toliman.CAE(toliman.Simulator(scene), centre="image")

    def test_blobs_of_a_crop_that_follows(self):
        blob = toliman.CAE(simulator, centre="image").to_bytes()
        self.assertEqual(struct.unpack_from("<I", blob, 20)[0] & 16, 16)
        self.assertEqual(struct.unpack_from("<d", blob, 104), (0,))
        for value in numpy.nan, 1e300, 1e12:  # which leaves no light
            with refused(toliman.InputError):
                toliman.CAE.from_bytes(self.with_number(blob, "<d", 104, value))
        with self.assertRaises(toliman.InputError):  # without the flag, the header ends before the number
            toliman.CAE.from_bytes(self.with_number(blob, "<I", 20, struct.unpack_from("<I", blob, 20)[0] & ~16))

    @staticmethod
    def with_number(blob, kind, offset, value):
        changed = bytearray(blob)
        struct.pack_into(kind, changed, offset, value)
        struct.pack_into("<I", changed, len(blob) - 4, zlib.crc32(changed[:-4]))
        return bytes(changed)

    def test_copies(self):
        latents = network.encode(frames)
        again = copy.copy(network)
        again.close()
        self.assertTrue((network.encode(frames) == latents).all())
        for other in (simulator, toliman.Template(simulator)):
            with refused(TypeError, "a"):
                copy.copy(other)


class Linear(unittest.TestCase):
    def test_template_is_weighted_least_squares(self):
        """Least squares with numpy, weighted by the expected counts."""
        template = toliman.Template(simulator)
        reference, derivative, variance = (simulator.image(kind) for kind in ("both", "separation", "variance"))
        information = (derivative**2 / variance).sum()
        expected = ((frames - reference) * derivative / variance).sum(axis=(1, 2)) / information
        numpy.testing.assert_allclose(template.encode(frames), expected, rtol=1e-9, atol=1e-14)
        self.assertEqual(template.encode(frames[3]), template.encode(frames)[3])
        self.assertAlmostEqual(template.sigma * information**0.5, 1, delta=1e-9)
        self.assertAlmostEqual(template.sigma / simulator.bounds.crb_px, 1, delta=1e-9)

    def test_components_are_singular_vectors(self):
        components = toliman.Components(simulator, bin=10, capacity=12)
        components.push(frames[0])
        components.push(frames[1:])
        self.assertEqual((len(components), components.info.pixels), (12, ROWS * COLS // 100))
        training = components.train(components=3)
        self.assertTrue(training.converged or training.iterations == 0)

        def binned(image):
            return image.reshape(-1, ROWS // 10, 10, COLS // 10, 10).sum(axis=(2, 4)).reshape(len(image), -1)
        residuals = binned(frames - simulator.image()) / binned(simulator.image("variance")[None]) ** 0.5
        residuals -= residuals.mean(axis=0)
        left, strengths, _ = numpy.linalg.svd(residuals, full_matrices=False)
        for place in range(3):
            values, share = components.series(place)
            expected = left[:, place] * strengths[place]
            expected *= numpy.sign(expected[abs(expected).argmax()])
            numpy.testing.assert_allclose(values, expected, atol=1e-5 * strengths[0])
            self.assertAlmostEqual(share, strengths[place]**2 / (strengths**2).sum(), delta=1e-6)
        seeds = []
        for seed in (1, 1, 2):
            components.train("dictionary", 2, iterations=1, seed=seed)
            seeds.append(components.series()[0].tolist())
        self.assertEqual(seeds[0], seeds[1])
        self.assertNotEqual(seeds[0], seeds[2])
        empty = toliman.Components(simulator)
        self.assertEqual(len(empty), 0)
        with refused(toliman.StateError):
            empty.train()


if __name__ == "__main__":
    unittest.main()
