"""toliman train --payload: the content of the files, read by an independent reader with numpy's rounding."""
import pathlib
import sys
import unittest

import numpy
from program import SCENES, ProgramTest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import tlmw


def bf16(values):
    fraction, exponent = numpy.frexp(values)
    return numpy.ldexp(numpy.rint(fraction * 256), exponent - 8)


def fp16(values, scale):
    return numpy.ldexp(numpy.ldexp(values, -scale).astype(numpy.float16).astype(float), scale)


class Payloads(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        text = (SCENES / "chapter.json").read_text()
        cls.scene = text.replace('"accuracy"', '"preprocess": {"project": ["flux_a", "shift_x"]}, "accuracy"')

    def blob(self, *arguments):
        (self.folder / "s.json").write_text(self.scene)
        self.succeed("train", "s.json", "--steps", "9", "--out", "w.tlmw", *arguments)
        return tlmw.Blob(self.folder / "w.tlmw")

    def test_numbers_are_the_nearest(self):
        exact, coarse, fine = self.blob(), self.blob("--payload", "bf16"), self.blob("--payload", "fp16")
        self.assertEqual((exact.weights_encoding, exact.planes_encoding, exact.projected), (0, 0, 2))
        self.assertEqual((coarse.weights_encoding, coarse.planes_encoding), (1, 1))
        self.assertEqual((fine.weights_encoding, fine.planes_encoding), (2, 2))
        for plane in range(2):  # the reference
            self.assertTrue((coarse.planes[plane] == exact.planes[plane]).all())
            self.assertTrue((fine.planes[plane] == exact.planes[plane]).all())
        self.assertGreater(abs(exact.planes[1]).max(), 1)  # without its low half it would be off by counts
        tensors = exact.weights + exact.planes[2:]
        for values, narrow in zip(tensors, coarse.weights + coarse.planes[2:]):
            self.assertTrue((narrow == bf16(values)).all())
        self.assertEqual(len(fine.scales), len(tensors))
        for values, narrow, scale in zip(tensors, fine.weights + fine.planes[2:], fine.scales):
            self.assertTrue((narrow == fp16(values, scale)).all())
            largest = numpy.ldexp(abs(narrow).max(), -scale)
            self.assertTrue(2**15 <= largest <= 65504 or (largest == 0 and scale == 0), largest)
        self.assertLess(coarse.size, 0.7 * exact.size)
        self.assertLess(fine.size, 0.75 * exact.size)

    def test_narrow_weights_encode(self):
        self.blob("--payload", "fp16")
        self.succeed("simulate", "s.json", "--frames", "0:2", "--out", "f.npy")
        self.assertEqual(len(self.succeed("encode", "--weights", "w.tlmw", "f.npy").splitlines()), 3)

    def test_unknown_payload(self):
        (self.folder / "s.json").write_text(self.scene)
        arguments = ("train", "s.json", "--out", "w.tlmw", "--payload", "fp8")
        self.refuse(2, "--payload", "fp8", "float32", "bf16", "fp16", arguments=arguments)


if __name__ == "__main__":
    unittest.main()
