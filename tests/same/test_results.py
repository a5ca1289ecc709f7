"""Tests that the library's results do not depend on the host: which results are bit-identical, and how closely the
others agree, over instruction sets, workers, OpenBLAS kernels and threads, orders of arrival, and points where objects
are saved and loaded. Prints a table: = identical bits, - not tested, else the largest difference over the largest
value. TOLIMAN_RESULTS is same_results; TOLIMAN_ORDERS, a number of orders, tests every choice instead of a few."""
# promise: components-repeat-their-bits
import os
import subprocess
import sys
import tempfile

import numpy

PROGRAM = os.environ["TOLIMAN_RESULTS"]
FULL = "TOLIMAN_ORDERS" in os.environ
ORDERS = int(os.environ.get("TOLIMAN_ORDERS", "1"))
ISAS = {"baseline": 0, "avx2": 1, "avx512": 2}
WORKERS = (2, 3, 4, 8) if FULL else (8,)
CORES = ("Prescott", "Nehalem", "Sandybridge", "Haswell", "SkylakeX", "Zen") if FULL else ("Haswell",)

# Tolerance of each axis, relative to the largest value: every result that is not listed must be bit-identical.
ANOTHER = numpy.inf  # training amplifies rounding errors: another network of the same quality
LATENTS = {"latents.f64": 1e-5, "core_latents.f64": 1e-5, "paper_latents.f64": 1e-5}  # with the same weights; the largest latent is about sigma
TRAINED = {"tied.tlmw": ANOTHER, "core.tlmw": ANOTHER, "unsupervised.tlmw": ANOTHER}
PRODUCTS = {"image.f64": 1e-14, "template.f64": 1e-9, "pca.f64": 1e-8, "dictionary.f64": 1e-8}
COUNTS = {"frames.f64": 0.2}  # the noise of one pixel, in case the last bit of an image changes a count
ALLOWED = {"instruction set": {**LATENTS, **TRAINED},
           "workers": {},
           "OpenBLAS kernels": {**PRODUCTS, **COUNTS, **TRAINED},
           "OpenBLAS threads": {"pca.f64": 1e-12},
           "order, save, load": {}}


def compute(folder, model="-", isa=2, workers=1, order=0, **environment):
    os.mkdir(folder)
    run = subprocess.run([PROGRAM, folder, model, str(isa), str(workers), str(order)], capture_output=True, text=True,
                         env={**os.environ, "OPENBLAS_NUM_THREADS": "1", **environment})
    if run.returncode not in (0, 77):
        sys.exit(f"{folder}: {run.stdout}{run.stderr}")
    return run.returncode == 0


def numbers(path):
    with open(path, "rb") as stream:
        data = stream.read()
    return data, numpy.frombuffer(data, numpy.float64) if path.endswith(".f64") else None


def difference(model, other):
    """0 if every bit is equal, else the largest difference over the largest value; infinity if bytes of other
    types differ."""
    (data, values), (others, other_values) = numbers(model), numbers(other)
    if data == others:
        return 0.0
    if values is None or len(values) != len(other_values):
        return numpy.inf
    largest = float(numpy.abs(values - other_values).max() / numpy.abs(values).max())
    return numpy.inf if numpy.isnan(largest) else largest


# promises: images-agree-between-cpus, processors-change-little, threads-change-no-bit
def main():
    with tempfile.TemporaryDirectory() as top:
        model = os.path.join(top, "model")
        best = next(isa for isa in sorted(ISAS.values(), reverse=True) if compute(os.path.join(top, f"try{isa}"), isa=isa))
        os.rename(os.path.join(top, f"try{best}"), model)
        runs = {axis: [] for axis in ALLOWED}

        def also(axis, **how):
            name = os.path.join(top, f"{len(os.listdir(top))}")
            if compute(name, model, **{"isa": best, **how}):
                runs[axis].append(name)

        for isa in range(best):
            also("instruction set", isa=isa)
        for workers in WORKERS:
            also("workers", workers=workers)
        for core in CORES:
            also("OpenBLAS kernels", OPENBLAS_CORETYPE=core)
        also("OpenBLAS threads", OPENBLAS_NUM_THREADS="2")
        for order in range(1, ORDERS + 1):
            also("order, save, load", order=order)

        bad = 0
        print(f"{'':20}" + "".join(f"{axis:>19}" for axis in runs))
        for result in sorted(os.listdir(model)):
            cells = []
            for axis, folders in runs.items():
                worst = max((difference(os.path.join(model, result), os.path.join(folder, result))
                             for folder in folders), default=0.0)
                fine = worst <= ALLOWED[axis].get(result, 0)
                bad += not fine
                cell = "-" if not folders else "=" if worst == 0 else "another" if worst == ANOTHER else f"{worst:.1e}"
                cells.append(cell + ("" if fine else " !"))
            print(f"{result:20}" + "".join(f"{cell:>19}" for cell in cells))
        print(f"{sum(map(len, runs.values())) + 1} runs, {bad} differ by more than is allowed")
        return min(bad, 1)


if __name__ == "__main__":
    sys.exit(main())
