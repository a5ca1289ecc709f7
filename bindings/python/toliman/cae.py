"""Convolutional autoencoder: compresses each frame to one number, the separation. Reference: include/toliman/cae.h."""
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
from ._arguments import Doubles, file_name, load_options, options_of, pointer, real, saved, shaped, whole
from ._encode import Fits, Values, encode
from ._handle import Handle
from ._log import log
from ._progress import Progress, Watch
from ._results import NetworkInfo, Training
from ._shown import brief_repr, documented, members_html
from ._words import number
from .sim import Scene, Simulator, simulator_of

# Frames for unsupervised training: an array [frame][row][column], or a function of (first, count) that returns one.
Frames = typing.Union[ArrayLike, typing.Callable[[int, int], ArrayLike]]


@documented(image="[side][side] in counts", mmse="mean squared error", mssim="mean structural similarity",
            photon_floor="mmse that noise alone causes")
class Reconstruction(typing.NamedTuple):
    """The network's reconstruction of a frame and its quality.

    image: [side][side] in counts, the network's crop of the frame. mmse, mssim: mean squared error and mean structural
    similarity between the frame and its reconstruction, both scaled to [0, 1] by the frame's extremes. photon_floor:
    the mmse that noise alone causes.
    """

    image: Doubles
    mmse: float
    mssim: float
    photon_floor: float

    def __repr__(self) -> str:
        return brief_repr(self)

    def _repr_html_(self) -> str:
        return members_html(self)


class CAE(Handle):
    """A convolutional autoencoder whose latent is the stellar separation in pixels.

    The preprocessing (crop, reference image, variance, nuisance images) comes from the scene and is saved with the
    weights. Threads may share a network; they wait while it is being trained.

        network = CAE(simulator)                   # random weights
        network.train()                            # half a second
        latent = network.encode(frame)             # px
        network.save("weights.tlmw")
        network = CAE.load("weights.tlmw")

    Parameters

    simulator: the scene, as a Simulator, a file or a dict; not needed afterwards.
    seed: seed of the random weights; None takes the scene's.
    layout: "flight" for frames of at least 256x256 pixels, "core" for the camera's 128x128 windows, or "paper", the
        layout of the chapter; None takes "core" if the frames have fewer than 256 rows or columns, else "flight".
    input: "whitened" ((counts - reference)/sigma per pixel), "residual" or "raw".
    centre: "scene", a crop at the same place of all frames, or "image", moved by whole pixels with each barycentre.
    threads: number of worker threads of encode(); 0 means one per processor.

    An untrained network of the default layout and input encodes too, as a control, but about a hundred times as
    noisily; see info.trained.

    Raises InputError if the nuisances leave nothing of the signal, UnsupportedError for frames smaller than the
    layout's crop.
    """

    _kind, _destroy = _raw.toliman_cae, "toliman_cae_destroy"

    def __init__(self, simulator: Simulator | Scene, *, seed: int | None = None, layout: str | None = None,
                 input: str = "whitened", centre: str = "scene", threads: int = 0):
        options = options_of(_raw.toliman_cae_options,
                             layout=layout_number(layout),
                             input=number("input", input, "TOLIMAN_CAE_INPUT"),
                             centre=number("centre", centre, "TOLIMAN_CAE_CENTRE"),
                             threads=whole("threads", threads, 2**32), log=log)
        simulator = simulator_of("simulator", simulator)
        seed = simulator.info.seed if seed is None else whole("seed", seed, 2**64)
        super().__init__(self._create(library.toliman_cae_create, simulator._c, seed, ctypes.byref(options)))

    @functools.cached_property
    def _trackers(self) -> weakref.WeakSet[Handle]:
        return weakref.WeakSet()

    @property
    def info(self) -> NetworkInfo:
        """Properties of the network. `cosine` is the predicted efficiency relative to the photon limit."""
        return self._read(library.toliman_cae_get_info, _raw.toliman_cae_info, NetworkInfo, None)

    def train(self, mode: str = "tied", *, steps: int = 0, learning_rate: float = 0, frames: Frames | None = None,
              count: int | None = None, epochs: int = 0, validation: int = 0, batch: int = 0, threads: int = 0,
              epoch: Epoch | None = None, progress: Progress | bool | None = None) -> Training:
        """Trains the network, or resumes a cancelled training with the same options.

        Parameters

        mode: "tied" fits the linear decoder to the scene's derivative image and needs no frames; the latent is then the
            separation in px. "unsupervised", as in the chapter, minimises the reconstruction error over frames; the
            latent then has no unit and may have either sign.
        steps: tied: number of steps; 0 means 300.
        learning_rate: in [0, 1]; 0 means 0.08 (tied) or 1e-3 (unsupervised).
        frames: unsupervised: an array [frame][row][column], or a function of (first, count) that returns one.
        count: number of frames; required if `frames` is a function.
        epochs: unsupervised: passes over the training frames in all; 0 means 300.
        validation: unsupervised: number of held-out frames; 0 means a tenth.
        batch: unsupervised: frames per step; 0 means 16.
        epoch: unsupervised: a function of (CAE, Training), called after each epoch with a network with the weights of
            this epoch and the result so far. The CAE may encode frames and may be saved during the call. A true return
            value cancels the training.

        Ctrl-C, and a progress function that raises or returns a true value, cancel the training, which can be resumed.

        Raises RuntimeError if an open Tracker uses this network, since its values would come from two networks;
        InputError if the training diverges; Cancelled.
        """
        if mode == "tied" and (frames is not None or count is not None or epoch is not None):
            raise ValueError("frames, count, epoch: allowed for mode = 'unsupervised' only")
        steps, epochs = whole("steps", steps, 2**32), whole("epochs", epochs, 2**32)
        if mode == "unsupervised" and steps or mode == "tied" and epochs:
            raise ValueError("steps: for mode = 'tied'; epochs: for mode = 'unsupervised'")
        if any(tracker._pointer is not None for tracker in self._trackers):
            raise RuntimeError("a Tracker uses this CAE: close the Tracker first, or train another CAE")
        with self._exclusive(), Watch(progress) as watch:
            source, count = _source(watch, frames, count, self.info)
            options = options_of(
                _raw.toliman_cae_train_options,
                mode=number("mode", mode, "TOLIMAN_CAE_MODE"), steps=steps or epochs,
                learning_rate=real("learning_rate", learning_rate),
                progress=watch.callback,
                frames=source, frame_count=count, validation=whole("validation", validation),
                batch=whole("batch", batch, 2**32), threads=whole("threads", threads, 2**32),
                epoch=_epoch_callback(watch, epoch))
            report = _raw.toliman_cae_training()
            watch.check(library.toliman_cae_train(self._c, ctypes.byref(options), ctypes.byref(report)))
        return Training._of(report)

    @typing.overload
    def encode(self, frames: ArrayLike, *, goodness: typing.Literal[False] = False,
               windows: ArrayLike | None = None, progress: Progress | bool | None = None) -> Values: ...

    @typing.overload
    def encode(self, frames: ArrayLike, *, goodness: typing.Literal[True],
               windows: ArrayLike | None = None, progress: Progress | bool | None = None) -> tuple[Values, Fits]: ...

    def encode(self, frames: ArrayLike, *, goodness: bool = False, windows: ArrayLike | None = None,
               progress: Progress | bool | None = None) -> Values | tuple[Values, Fits]:
        """Encodes one frame [row][column] to its latent (px), a float; or frames [frame][row][column] to an array.

        Arrays of a pixel type of C (u1, u2, u4, i2, i4, f4, f8 and big-endian u2, u4, i2, f4) with contiguous rows are
        read in place; others are copied as float64.

        Cosmic rays, hot and dead pixels are left out, up to 30 per frame. Issues a FitWarning if the chi-square of frames
        against the scene's linear model is poor or too good.

        goodness: return a pair of the latents and the goodness of fit: a FrameGoodness for one frame, or a structured
        array with a field for each member of toliman_frame_goodness, whose `goodness` is a number TOLIMAN_GOODNESS_...

        windows: row and column on the detector of each frame's first pixel, [frame][2] or one pair for all: the scene's bad
        pixels are left out there, if it has detector.window.

        Raises ValueError for another shape than `shape`, InputError for a non-finite count.
        """
        return encode(library.toliman_cae_encode, self._c, frames, self.shape, goodness, windows, progress)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the input frames."""
        info = self.info
        return info.rows, info.cols

    def _image(self) -> Doubles:
        side = self.info.side
        return numpy.empty((side, side))

    def decode(self, latent: float) -> Doubles:
        """Returns the decoder's output for a latent (px): the whitened residual [side][side], in sigmas of each pixel.
        Raises UnsupportedError for layout "paper"."""
        image = self._image()
        check(library.toliman_cae_decode(self._c, real("latent", latent), pointer(image), len(image)))
        return image

    def target(self) -> Doubles:
        """Returns the ideal decoder output per px of latent: the whitened derivative image [side][side], orthogonal to
        the projected nuisances."""
        image = self._image()
        check(library.toliman_cae_get_target(self._c, pointer(image), len(image)))
        return image

    def reconstruct(self, frame: ArrayLike) -> Reconstruction:
        """Reconstructs a frame [row][column] of counts, and compares it with the frame."""
        counts, image = shaped("frame", frame, self.shape), self._image()
        quality = [ctypes.c_double() for _ in range(3)]
        check(library.toliman_cae_reconstruct(self._c, pointer(counts), counts.shape[1], pointer(image), len(image),
                                              *map(ctypes.byref, quality)))
        return Reconstruction(image, *(number.value for number in quality))

    def save(self, path: str | os.PathLike[str], *, weights: str = "float32", planes: str = "float32",
             training: bool = False) -> None:
        """Writes the network to a file, atomically.

        weights, planes: encoding of the weights, and of the variance, target and nuisance images: "float32" (exact),
        "bf16" or "fp16". training: also save the state of the last training, so that train() can resume it.
        """
        check(library.toliman_cae_save_file(self._c, _save_options(weights, planes, training), file_name(path)))

    def to_bytes(self, *, weights: str = "float32", planes: str = "float32", training: bool = False) -> bytes:
        """Returns the contents of a file written by save() with the same options."""
        options = _save_options(weights, planes, training)
        return saved(functools.partial(library.toliman_cae_save, self._c, options))

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, threads: int = 0) -> CAE:
        """Loads a network from a file written by save()."""
        return cls._adopt(cls._create(library.toliman_cae_load_file, file_name(path), load_options(threads)))

    @classmethod
    def from_bytes(cls, content: bytes, *, threads: int = 0) -> CAE:
        """Loads a network from the bytes returned by to_bytes()."""
        content = memoryview(content).tobytes()
        return cls._adopt(cls._create(library.toliman_cae_load, content, len(content), load_options(threads)))

    def __reduce__(self):
        return type(self).from_bytes, (self.to_bytes(),)

    def _summary(self) -> str:
        info = self.info
        state = f"trained, cosine {info.cosine:.4f}" if info.trained else "not trained"
        return f"CAE of layout {info.layout} for {info.rows}x{info.cols} frames, {state}"


def layout_number(layout: str | None) -> int:
    """Returns the number of a layout; 0, that of the frames' size, for None."""
    return 0 if layout is None else number("layout", layout, "TOLIMAN_CAE_LAYOUT")


def _save_options(weights: str, planes: str, training: bool) -> typing.Any:
    return ctypes.byref(options_of(
        _raw.toliman_cae_save_options, with_training=int(training),
        weights_encoding=number("weights", weights, "TOLIMAN_CAE_ENCODING"),
        planes_encoding=number("planes", planes, "TOLIMAN_CAE_ENCODING")))


class _SoFar(CAE):
    """The network of a running training, which the library destroys."""

    _destroy = ""


# Called after each epoch of unsupervised training. A true return value cancels the training.
Epoch = typing.Callable[[CAE, Training], typing.Any]


def _epoch_callback(watch: Watch, epoch: Epoch | None) -> typing.Any:
    """Returns the callback of C that calls `epoch`."""
    if epoch is None:
        return ctypes.cast(0, _raw.toliman_epoch_fn)
    given = epoch

    def call(so_far: typing.Any, result: typing.Any, _: object) -> int:
        with _SoFar._adopt(so_far) as network:
            return int(bool(given(network, Training._of(result.contents))))

    return _raw.toliman_epoch_fn(lambda *arguments: watch.run(call, *arguments))


def _source(watch: Watch, frames: Frames | None, count: int | None, info: NetworkInfo) -> tuple[typing.Any, int]:
    """Returns the callback that provides the training frames to C, and their number."""
    if frames is None:
        return ctypes.cast(0, _raw.toliman_frames_fn), 0
    if callable(frames):
        if count is None:
            raise ValueError("count = None: must be given if frames is a function")
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
