"""The same networks in PyTorch, one thread: agreement with the results in FOLDER of each instruction set, and times.

Usage: torch_cae.py FOLDER. Prints one JSON object per line. A form is the memory format of the images, and the function
that computes the convolutions of the decoder; none needs a copy to reorder an image. The fastest form counts."""
import glob
import itertools
import json
import math
import os
import sys
import time

import numpy as np
import torch
import torch.nn.functional as F

SIDES = {"flight": 256, "paper": 256, "core": 128}
BATCH = 16
FORMATS = {"channels_last": torch.channels_last, "contiguous": torch.contiguous_format}


def shapes(layout):
    deep = SIDES[layout] // 16
    return [("conv1", (8, 1, 3, 3)), ("conv2", (16, 8, 3, 3)), ("conv3", (32, 16, 3, 3)), ("conv4", (64, 32, 3, 3)),
            ("latent", (deep, deep, 64)), ("expand", (deep, deep, 64)), ("deconv4", (64, 32, 3, 3)),
            ("deconv3", (32, 16, 3, 3)), ("deconv2", (16, 8, 3, 3)), ("deconv1", (8, 1, 3, 3))]


def biases(name, shape):
    return {"latent": (1,), "expand": shape}.get(name, (shape[1] if name.startswith("deconv") else shape[0],))


def parameters(layout, path, dtype=torch.float32):
    values, at, tensors = np.fromfile(path, np.float32), 0, {}
    for name, shape in shapes(layout):
        for suffix, dimensions in (("weight", shape), ("bias", biases(name, shape))):
            size = int(np.prod(dimensions))
            tensors[f"{name}.{suffix}"] = torch.tensor(values[at:at + size].reshape(dimensions), dtype=dtype,
                                                      requires_grad=True)
            at += size
    assert at == len(values)
    return tensors


def in_form(p, memory, convolution):
    """The parameters as a form needs them, as leaves of the gradient."""
    out = {}
    for name, value in p.items():
        value = value.detach()
        if name in ("latent.weight", "expand.weight", "expand.bias") and memory == "contiguous":
            value = value.permute(2, 0, 1)
        if name.startswith("deconv") and name.endswith("weight") and convolution == "conv2d":
            value = value.transpose(0, 1).flip(2, 3)
        if value.dim() == 4:
            value = value.contiguous(memory_format=FORMATS[memory])
        out[name] = value.clone(memory_format=torch.preserve_format).requires_grad_(True)
    return out


def encode(p, x, paper, memory="channels_last"):
    places = []
    for k in range(1, 5):
        x = F.conv2d(x, p[f"conv{k}.weight"], p[f"conv{k}.bias"], padding=1)
        if paper:
            x, place = F.max_pool2d(F.elu(x), 2, return_indices=True)
            places.append(place)
        else:
            x = F.elu(F.avg_pool2d(x, 2))
    x = x.permute(0, 2, 3, 1) if memory == "channels_last" else x  # the order in memory
    return x.reshape(x.shape[0], -1) @ p["latent.weight"].reshape(-1, 1) + p["latent.bias"], places


def decode(p, z, places, paper, memory="channels_last", convolution="conv_transpose2d"):
    x = F.elu(z * p["expand.weight"].reshape(1, -1) + p["expand.bias"].reshape(1, -1))
    deep = math.isqrt(x.shape[1] // 64)
    x = x.reshape(-1, deep, deep, 64).permute(0, 3, 1, 2) if memory == "channels_last" else x.reshape(-1, 64, deep, deep)
    for k in range(4, 0, -1):
        x = F.max_unpool2d(x, places[k - 1], 2) if paper else F.interpolate(x, scale_factor=2, mode="nearest")
        x = getattr(F, convolution)(x, p[f"deconv{k}.weight"], p[f"deconv{k}.bias"], padding=1)
        x = F.elu(x) if k > 1 else x
    return x


def difference(ours, theirs):
    theirs = theirs.detach().numpy().reshape(-1).astype(np.float64)
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


def compare(folder, layout):
    """In double, so that the differences are the rounding errors of the library alone."""
    paper, p = layout == "paper", parameters(layout, f"{folder}/{layout}.weights", torch.float64)
    x = torch.tensor(np.fromfile(f"{folder}/{layout}.input", np.float32).reshape(1, 1, SIDES[layout], -1), dtype=torch.float64)
    z, places = encode(p, x, paper)
    y = decode(p, z, places, paper)
    ((y - x) ** 2).mean().backward()
    for path in sorted(glob.glob(f"{folder}/{layout}-*.latent")):
        ours = os.path.splitext(path)[0]
        gradients = parameters(layout, ours + ".gradient")
        yield {"part": "agreement", "layout": layout, "isa": ours.split("-")[-1],
               "latent": difference(np.fromfile(ours + ".latent", np.float32), z),
               "output": difference(np.fromfile(ours + ".output", np.float32), y),
               "gradient": max(difference(gradients[name].detach().numpy().reshape(-1), tensor.grad)
                               for name, tensor in p.items())}


def median_ms(work, calls, repeats=5):
    work()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        for _ in range(calls):
            work()
        times.append((time.process_time() - start) / calls)
    return 1e3 * sorted(times)[repeats // 2]


def check(p, exact, x, paper, memory, convolution):
    """Exits unless this form computes the image of the exact one: in float32, other pixels may win a max pooling."""
    z, places = encode(p, x, paper, memory)
    found = difference(decode(p, z, places, paper, memory, convolution).detach().numpy().reshape(-1), exact)
    if not found < 1e-2:
        sys.exit(f"torch_cae: {memory}, {convolution}: differs by {found:.1e} from the network in double")


def measure(folder, layout, memory, convolution):
    paper, plain = layout == "paper", parameters(layout, f"{folder}/{layout}.weights")
    p = in_form(plain, memory, convolution)
    side = SIDES[layout]
    one = torch.randn(1, 1, side, side)
    many = torch.randn(BATCH, 1, side, side).contiguous(memory_format=FORMATS[memory])
    exact = {name: value.detach().double() for name, value in plain.items()}
    check(p, decode(exact, *encode(exact, one.double(), paper), paper), one, paper, memory, convolution)
    optimiser = torch.optim.Adam(p.values(), 1e-6)

    def infer(images):
        with torch.inference_mode():
            encode(p, images, paper, memory)

    def step():
        optimiser.zero_grad(set_to_none=True)
        z, places = encode(p, many, paper, memory)
        F.mse_loss(decode(p, z, places, paper, memory, convolution), many).backward()
        optimiser.step()

    times = {"training_ms": median_ms(step, 1, 3) / BATCH}
    if convolution == "conv2d":  # the encoder is the same with both
        times["encode_ms"] = min(median_ms(lambda: infer(one), 20), median_ms(lambda: infer(many), 2) / BATCH)
    return {"part": "peer", "peer": f"PyTorch {torch.__version__}, {memory}, {convolution}", "layout": layout, **times}


def main():
    torch.set_num_threads(1)
    torch.manual_seed(1)
    folder = sys.argv[1]
    for layout in SIDES:
        for agreement in compare(folder, layout):
            print(json.dumps(agreement), flush=True)
        for memory, convolution in itertools.product(FORMATS, ("conv2d", "conv_transpose2d")):
            print(json.dumps(measure(folder, layout, memory, convolution)), flush=True)


os.environ.setdefault("OMP_NUM_THREADS", "1")
main()
