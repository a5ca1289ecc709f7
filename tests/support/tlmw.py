"""Reads weights blobs as specified in tools/docs/formats.md, with numpy and zlib alone."""
import pathlib
import struct
import zlib

import numpy

TENSORS = (72, 8, 1152, 16, 4608, 32, 18432, 64, 16384, 1, 16384, 16384, 18432, 32, 4608, 16, 1152, 8, 72, 1)
PIXELS = 256 * 256
FLOAT32, BF16, FP16 = range(3)


class Blob:
    """weights and planes: one array of float64 per tensor and plane; scales: exponents of those in fp16."""

    def __init__(self, path):
        content = pathlib.Path(path).read_bytes()
        self.size = len(content)
        magic, version, size = struct.unpack_from("<4sIQ", content)
        self.projected, self.weights_encoding, self.planes_encoding = struct.unpack_from("<IHH", content, 64)
        packed_weights, packed_planes = struct.unpack_from("<II", content, 96)
        checksum, = struct.unpack("<I", content[-4:])
        if (magic, version, size, 108 + packed_weights + packed_planes) != \
                (b"TLMW", 2 if self.projected <= 8 else 3, self.size, self.size):
            raise ValueError("not a whole blob")
        if zlib.crc32(content[:-4]) != checksum:
            raise ValueError("checksum")
        self.scales = []
        self.raw_size = 0
        self.weights = self.payload(content[104 : 104 + packed_weights], TENSORS, [self.weights_encoding] * 20)
        encodings = [FLOAT32] * 2 + [self.planes_encoding] * (2 + self.projected)
        self.planes = self.payload(content[104 + packed_weights : -4], [PIXELS] * len(encodings), encodings)

    def payload(self, packed, counts, encodings):
        raw = zlib.decompress(packed)
        self.raw_size += len(raw)
        at, blocks = 0, []
        for count, encoding in zip(counts, encodings):
            scale = 0
            if encoding == FP16:
                scale, = struct.unpack_from("<h", raw, at)
                self.scales.append(scale)
                at += 2
            width = 4 if encoding == FLOAT32 else 2
            words = numpy.frombuffer(raw, numpy.uint8, width * count, at).reshape(width, count).T.copy()
            at += width * count
            if encoding == FLOAT32:
                values = words.view("<f4")
            elif encoding == FP16:
                values = words.view("<f2")
            else:
                values = numpy.hstack([numpy.zeros_like(words), words]).view("<f4")
            blocks.append(numpy.ldexp(values[:, 0].astype(float), scale))
        if at != len(raw):
            raise ValueError("payload of another size")
        return blocks
