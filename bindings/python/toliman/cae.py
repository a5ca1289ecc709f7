"""The convolutional autoencoder: a frame -> one number; include/toliman/cae.h is the manual."""
from __future__ import annotations

import ctypes
import functools
import os
import typing
import weakref

import numpy
from numpy.typing import ArrayLike

from . import _raw
from ._library import check, library
from ._arguments import Doubles, file_name, of_kind, options_of, pointer, real, saved, shaped, whole
from ._encode import Values, encode
from ._handle import Handle
from ._progress import Progress, Watch
from ._results import NetworkInfo, Training
from ._words import number
from .sim import Simulator

_SIDE = 256

# Frames for unsupervised training: an array [frame][row][column], or a function of (first, count) that gives such ones.
Frames = typing.Union[ArrayLike, typing.Callable[[int, int], ArrayLike]]


class Reconstruction(typing.NamedTuple):
    """A frame as the network sees it again, [256][256] in counts, and how close it comes: mean squared error and mean
    structural similarity of both scaled to 0 ... 1, and the error that noise alone leaves."""

    image: Doubles
    mmse: float
    mssim: float
    photon_floor: float


class CAE(Handle):
    """A network that knows its scene. Calls of one that is not being trained may run together from several threads.

        network = CAE(simulator)                   # random weights
        network.train()                            # half a second
        latent = network.encode(frame)             # px
        network.save("weights.tlmw")
        network = CAE.load("weights.tlmw")

    seed: of the random weights, by default the scene's. layout: flight, which reaches the photon limit, or paper, the
    chapter's. input: whitened, residual or raw. With random weights it encodes too, as a control: some hundred times as
    noisy; info.trained tells.
    """

    _kind, _end = _raw.toliman_cae, "toliman_cae_destroy"

    def __init__(self, simulator: Simulator, *, seed: int | None = None, layout: str = "flight",
                 input: str = "whitened"):
        options = options_of(_raw.toliman_cae_options, library.toliman_cae_options_init,
                             layout=number("layout", layout, "TOLIMAN_CAE_LAYOUT"),
                             input=number("input", input, "TOLIMAN_CAE_INPUT"))
        of_kind("simulator", simulator, Simulator)
        seed = simulator.info.seed if seed is None else whole("seed", seed, 2**64)
        super().__init__(self._made(library.toliman_cae_create, simulator._c, seed, ctypes.byref(options)))

    @functools.cached_property
    def _trackers(self) -> weakref.WeakSet[Handle]:
        return weakref.WeakSet()

    @property
    def info(self) -> NetworkInfo:
        """Facts of the network; `cosine` is the efficiency to expect."""
        return self._read(library.toliman_cae_get_info, _raw.toliman_cae_info, NetworkInfo)

    def train(self, mode: str = "tied", *, steps: int = 0, learning_rate: float = 0, frames: Frames | None = None,
              count: int | None = None, epochs: int = 0, validation: int = 0, batch: int = 0, threads: int = 0,
              progress: Progress | bool | None = None) -> Training:
        """Trains, or goes on with a training that was stopped.

        tied: fits the decoder to the scene's derivative image; needs no frames; steps, default 300. unsupervised: the
        chapter's, over `frames`, an array [frame][row][column] or a function of (first, count) that gives them, then
        with the `count` of all; epochs, default 300, batch, default 16, and `validation`, default a tenth, frames kept
        back. 0 is the default everywhere. The network is not for other calls meanwhile. Ctrl-C and a progress function
        that raises or answers something true stop; what is done so far can be taken up.
        """
        if mode == "tied" and (frames is not None or count is not None):
            raise ValueError("frames are for mode = 'unsupervised'")
        if any(tracker._pointer is not None for tracker in self._trackers):
            raise RuntimeError("a Tracker uses this CAE: its values would be of two networks; train another")
        with self._alone(), Watch(progress) as watch:
            source, count = _source(watch, frames, count, self.info)
            options = options_of(
                _raw.toliman_cae_train_options, library.toliman_cae_train_options_init,
                mode=number("mode", mode, "TOLIMAN_CAE_MODE"), steps=whole("steps", steps, 2**32),
                epochs=whole("epochs", epochs, 2**32), learning_rate=real("learning_rate", learning_rate),
                progress=watch.callback,
                frames=source, frame_count=count, validation=whole("validation", validation),
                batch=whole("batch", batch, 2**32), threads=whole("threads", threads, 2**32))
            report = _raw.toliman_cae_training()
            watch.check(library.toliman_cae_train(self._c, ctypes.byref(options), ctypes.byref(report)))
        return Training._of(report)

    @typing.overload
    def encode(self, frames: ArrayLike, *, chi_square: typing.Literal[False] = False, threads: int = 0,
               progress: Progress | bool | None = None) -> Values: ...

    @typing.overload
    def encode(self, frames: ArrayLike, *, chi_square: typing.Literal[True], threads: int = 0,
               progress: Progress | bool | None = None) -> tuple[Values, Values]: ...

    def encode(self, frames: ArrayLike, *, chi_square: bool = False, threads: int = 0,
               progress: Progress | bool | None = None) -> Values | tuple[Values, Values]:
        """Latent (px) of a frame [row][column], a float; or of frames [frame][row][column], an array. Arrays of a pixel
        type of C (u1 to u4, i2, i4, f4, f8, and big-endian u2, u4, i2, f4) are read where they lie if rows are
        contiguous; others are copied. chi_square: a pair, of the latents and of what the scene's linear model leaves of
        each frame, per degree of freedom: 1 for frames of the scene, far larger for damaged ones."""
        return encode(library.toliman_cae_encode_many, self._c, frames, self.shape, chi_square, threads, progress)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the frames it takes."""
        info = self.info
        return info.rows, info.cols

    def decode(self, latent: float) -> Doubles:
        """Whitened residual [256][256], in sigmas of a pixel, that the decoder paints for a latent (px)."""
        image = numpy.empty((_SIDE, _SIDE))
        check(library.toliman_cae_decode(self._c, real("latent", latent), pointer(image), _SIDE))
        return image

    def target(self) -> Doubles:
        """Whitened, projected derivative image [256][256], per px: what the decoder should paint for a latent of 1."""
        image = numpy.empty((_SIDE, _SIDE))
        check(library.toliman_cae_get_target(self._c, pointer(image), _SIDE))
        return image

    def reconstruct(self, frame: ArrayLike) -> Reconstruction:
        """A frame [row][column] as the network sees it again, and how close it comes."""
        counts, image = shaped("frame", frame, self.shape), numpy.empty((_SIDE, _SIDE))
        quality = [ctypes.c_double() for _ in range(3)]
        check(library.toliman_cae_reconstruct(self._c, pointer(counts), counts.shape[1], pointer(image), _SIDE,
                                              *map(ctypes.byref, quality)))
        return Reconstruction(image, *(number.value for number in quality))

    def save(self, path: str | os.PathLike[str], *, weights: str = "float32", planes: str = "float32",
             training: bool = False) -> None:
        """Writes the weights blob, as a whole or not at all. weights, planes (variance, target and nuisance images):
        float32, bf16 or fp16. training: also where the last training stands, to go on with."""
        check(library.toliman_cae_save_file(self._c, _save_options(weights, planes, training), file_name(path)))

    def to_bytes(self, *, weights: str = "float32", planes: str = "float32", training: bool = False) -> bytes:
        """The same as bytes."""
        options = _save_options(weights, planes, training)
        return saved(functools.partial(library.toliman_cae_save, self._c, options))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> CAE:
        """A network from a weights blob."""
        return cls._adopt(cls._made(library.toliman_cae_load_file, file_name(path), None))

    @classmethod
    def from_bytes(cls, content: bytes) -> CAE:
        """A network from the bytes of a weights blob."""
        content = memoryview(content).tobytes()
        return cls._adopt(cls._made(library.toliman_cae_load, content, len(content), None))

    def __reduce__(self):
        return type(self).from_bytes, (self.to_bytes(),)

    def _told(self) -> str:
        info = self.info
        state = f"trained, cosine {info.cosine:.4f}" if info.trained else "not trained"
        return f"CAE of layout {info.layout} for frames of {info.rows}x{info.cols}, {state}"

    def _repr_html_(self) -> str:
        return self.info._repr_html_()


def _save_options(weights: str, planes: str, training: bool) -> typing.Any:
    return ctypes.byref(options_of(
        _raw.toliman_cae_save_options, library.toliman_cae_save_options_init, training=int(training),
        weights_encoding=number("weights", weights, "TOLIMAN_CAE_ENCODING"),
        planes_encoding=number("planes", planes, "TOLIMAN_CAE_ENCODING")))


def _source(watch: Watch, frames: Frames | None, count: int | None, info: NetworkInfo) -> tuple[typing.Any, int]:
    """The callback that gives frames to C, and how many there are."""
    if frames is None:
        return ctypes.cast(0, _raw.toliman_frames_fn), 0
    if callable(frames):
        if count is None:
            raise ValueError("count: must be given where frames is a function")
        of_range = frames
    else:
        images = shaped("frames", frames, (-1 if count is None else count, info.rows, info.cols))
        count = len(images)

        def of_range(first: int, number: int) -> ArrayLike:
            return images[first:first + number]

    def fill(first: int, number: int, counts: typing.Any, _: object) -> int:
        wanted = (number, info.rows, info.cols)
        numpy.ctypeslib.as_array(counts, wanted)[:] = shaped("frames", of_range(first, number), wanted)
        return _raw.TOLIMAN_OK

    return _raw.toliman_frames_fn(lambda *arguments: watch.run(fill, *arguments)), whole("count", count)
