"""A program with types, as users write it, which mypy accepts with the rules of --strict (check/types). It is not run."""
# mypy: disallow-untyped-defs, disallow-incomplete-defs, disallow-untyped-calls, disallow-any-generics, disallow-subclassing-any
# mypy: warn-return-any, warn-unused-ignores, no-implicit-reexport, strict-equality, disallow-untyped-decorators
import numpy
import numpy.typing

import toliman


def separations(frames: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
    simulator = toliman.Simulator("chapter.json", progress=True)
    fit = toliman.Fit(simulator, free=["scale"])
    results = fit.frames(frames, times_days=[1.0, 2.0])
    table = results.to_table()
    table.write("fits.ecsv")
    found: numpy.typing.NDArray[numpy.float64] = results["separation_px"]
    return found


def search(path: str) -> float:
    series = toliman.Measurements(path, kind="reduced")
    found = toliman.planets(series, max_planets=2)
    for planet in found.planets:
        print(planet.period[1], planet.verdict, planet.to_pandas())
    peak: toliman.Peak = toliman.period(series.t, series.y, series.sigma)
    times, displacements = toliman.Simulator("sky.json").series()
    with toliman.Periodogram(*toliman.suited_grid(times)) as periodogram:
        periodogram.push_many(times, displacements)
        peaks: toliman.Rows[toliman.Peak] = periodogram.peaks()
        first = peaks[0].period
    sky = toliman.Sky("alpha-cen", altitude_km=600)
    seen = sky.predict(numpy.array([toliman.parse_time("2030-01-01")]))
    reduced = sky.reduce(series, scale_sigma=1e-3)
    same = toliman.Measurements.of_table(reduced.to_table())
    with toliman.Tracker(None, *toliman.suited_grid(times), folder="mission") as tracker:
        records = tracker.records()
        outcomes = tracker.push_many([toliman.Frame(numpy.zeros((2, 2)), 1, 2)])
    print(seen["factor"], len(same), records.to_table(), toliman.Rows(outcomes).to_table())
    return peak.period + first


print(search("a.csv"))
