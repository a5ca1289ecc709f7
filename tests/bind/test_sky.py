"""Tests binary orbits and planets of a scene against Kepler's equation by bisection and the textbook's angles."""
import copy
import math
import unittest

from package import toliman

SCENE = {
    "schema": "toliman-scene/1",
    "telescope": {"aperture_m": 0.125, "pupil_samples": 64},
    "band": {"wavelength_nm": 580},
    "stars": {
        "A": {"spectrum": {"kind": "blackbody", "temperature_k": 5790}, "mass_sun": 1.0788},
        "B": {"spectrum": {"kind": "blackbody", "temperature_k": 5260}, "mass_sun": 0.9092},
    },
    "binary": {"separation_arcsec": 2, "distance_pc": 1.33},
    "cadence": {"frames": 200, "interval_days": 3.7, "peak_photons": 1e4},
    "detector": {"shape": [16, 16], "pixel_scale_arcsec": 0.375},
}
ALPHA_CEN = {"period_years": 79.762, "semi_major_arcsec": 17.4930, "eccentricity": 0.51947, "inclination_deg": 79.2430,
             "node_deg": 205.073, "periastron_deg": 231.519, "epoch": 1955.564}  # Akeson et al. 2021, AJ 162, 14


def true_anomaly(mean, e):
    """By bisection of Kepler's equation, over one revolution from periastron, and the half-angle formula."""
    mean %= 2 * math.pi
    low, high = 0.0, 2 * math.pi
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if middle - e * math.sin(middle) < mean else (low, middle)
    half = (low + high) / 4
    return 2 * math.atan2(math.sqrt(1 + e) * math.sin(half), math.sqrt(1 - e) * math.cos(half))


def radius(anomaly, e):
    """In units of the semi-major axis."""
    return (1 - e * e) / (1 + e * math.cos(anomaly))


def place(orbit, date):
    """Separation and position angle (deg) from the spherical triangle of node, line of sight and star."""
    e = orbit["eccentricity"]
    anomaly = true_anomaly(2 * math.pi * (date - orbit["epoch"]) / orbit["period_years"], e)
    r = orbit["semi_major_arcsec"] * radius(anomaly, e)
    u = anomaly + math.radians(orbit["periastron_deg"])
    i = math.radians(orbit["inclination_deg"])
    angle = math.atan2(math.sin(u) * math.cos(i), math.cos(u)) + math.radians(orbit["node_deg"])
    return r * math.sqrt(1 - (math.sin(u) * math.sin(i)) ** 2), math.degrees(angle)


class BinaryOrbit(unittest.TestCase):
    def check_place(self, orbit, expected_orbit, date, rotation=0):
        scene = copy.deepcopy(SCENE)
        scene["binary"] = {"date": date, "orbit": orbit}
        scene["detector"]["rotation_deg"] = rotation
        scene["telescope"]["pupil_samples"] = 128
        separation, angle = place(expected_orbit, date)
        rotated = math.radians(angle - rotation)
        (ax, ay), (bx, by) = toliman.Simulator(scene).offsets()
        self.assertAlmostEqual(bx - ax, -separation * math.sin(rotated) / 0.375, delta=1e-11)
        self.assertAlmostEqual(by - ay, separation * math.cos(rotated) / 0.375, delta=1e-11)

    def test_alpha_centauri(self):
        for date in (1900.0, 1955.564, 2015.8, 2026.0, 2027.0, 2037.9, 2100.0):
            with self.subTest(date=date):
                self.check_place("alpha-cen", ALPHA_CEN, date)
        self.check_place("alpha-cen", ALPHA_CEN, 2027.0, rotation=-33)

    def test_elements(self):
        for changes in ({}, {"inclination_deg": 0}, {"inclination_deg": 150}, {"eccentricity": 0}, {"eccentricity": 0.9999},
                        {"period_years": 0.31}, {"node_deg": -40, "periastron_deg": -310}):
            orbit = dict(ALPHA_CEN, semi_major_arcsec=5, **changes)
            for date in (1800.0, 1962.3, 2027.0):
                with self.subTest(changes=changes, date=date):
                    self.check_place(orbit, orbit, date)

    def test_face_on(self):
        """Inclination 0, from periastron on: the angle is node + periastron and grows."""
        orbit = dict(ALPHA_CEN, semi_major_arcsec=5, inclination_deg=0, node_deg=30, periastron_deg=20)
        self.assertAlmostEqual(place(orbit, orbit["epoch"])[1], 50)
        self.assertGreater(place(orbit, orbit["epoch"] + 1)[1], 50)
        self.check_place(orbit, orbit, orbit["epoch"])


class PlanetSignal(unittest.TestCase):
    def test_displacements(self):
        for e, argument, phase in ((0.1, 0, 0), (0.5, 90, 1), (0.5, -37, -2.5), (0.9, 200, 3), (0.9999, 10, 30)):
            scene = copy.deepcopy(SCENE)
            scene["signal"] = {"kind": "planet", "star": "A", "mass_earth": 300, "semi_major_au": 0.5, "eccentricity": e,
                               "argument_deg": argument, "phase_rad": phase}
            earth = 3.986004e14 / 1.3271244e20 * 300
            amplitude = earth / (1.0788 + earth) * 0.5 / 1.33 / 0.375
            gauss = 2 * math.pi / 365.2568983840419  # mean motion of a massless planet at 1 au, rad per day
            motion = gauss * math.sqrt((1.0788 + earth) / 0.5**3)
            with self.subTest(e=e):
                for t, displacement in zip(*toliman.Simulator(scene).series(0, 200)):
                    anomaly = true_anomaly(motion * t + phase, e)
                    expected = amplitude * radius(anomaly, e) * math.sin(anomaly + math.radians(argument))
                    self.assertAlmostEqual(displacement / amplitude, expected / amplitude, delta=1e-10)

    def test_mean_over_a_period(self):
        """The time average of r/a sin(v + w) is -3/2 e sin w."""
        scene = copy.deepcopy(SCENE)
        scene["signal"] = {"kind": "planet", "mass_earth": 300, "semi_major_au": 1}
        scene["signal"].update(eccentricity=0.4, argument_deg=60)
        earth = 3.986004e14 / 1.3271244e20 * 300
        period = 365.2568983840419 / math.sqrt(1.0788 + earth)
        scene["cadence"].update(frames=1000, interval_days=period / 1000)
        amplitude = earth / (1.0788 + earth) / 1.33 / 0.375
        mean = toliman.Simulator(scene).series(0, 1000)[1].mean()
        self.assertAlmostEqual(mean / amplitude, -1.5 * 0.4 * math.sin(math.radians(60)), delta=1e-9)


if __name__ == "__main__":
    unittest.main()
