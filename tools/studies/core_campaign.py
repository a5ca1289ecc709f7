"""Frames of the camera's window of 128x128 pixels: does the network of layout `core` reach the Cramer-Rao bound, and do network,
template and fit find an Earth? The short form: test_core_campaign.py.

    core_campaign.py [--seeds 20] [--folder build/core]

Fresh frames of the scene mission with this shape and an amplitude of 6.9e-6 px, by `toliman.experiment`, and twice as many
series without signal: with nothing else unknown (network and template), and with the parameters that the fit has free projected
out, so that all three have the same bound. Exit status 1: an efficiency below 0.95, a planet that is missed, or more than one
false alarm."""
import argparse
import json
import logging
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "build" / "python"))
import toliman  # noqa: E402

SCENES = ROOT / "examples" / "scenes"
SIDE, AMPLITUDE, EFFICIENCY = 128, "6.9e-6", 0.95
FREE = ["flux_a", "flux_b", "shift_x", "shift_y", "roll", "background"]  # of the fit, with the separation
CASES = {"none": ([], "cae,template"), "those of the fit": (FREE, "cae,template,fit")}


def scene_of(projected, **groups):
    """Returns the scene with frames of the window's size; `groups` are merged with the scene's."""
    scene = json.loads((SCENES / "mission.json").read_text())
    for star in scene["stars"].values():
        star["spectrum"]["file"] = str(SCENES / star["spectrum"]["file"])
    scene["detector"]["shape"] = [SIDE, SIDE]
    scene["preprocess"] = {"project": projected}
    for group, members in groups.items():
        scene[group] = {**scene[group], **members}
    return scene


def experiment(options, name, scene, methods):
    """Returns the table `real` of `toliman.experiment`."""
    out = options.folder / name
    out.with_suffix(".json").write_text(json.dumps(scene))
    subprocess.run([sys.executable, "-m", "toliman.experiment", out.with_suffix(".json"), "--tables", "real", "--amplitudes",
                    AMPLITUDE, "--methods", methods, "--seeds", str(options.seeds), "--blind", str(2 * options.seeds),
                    "--out", out], check=True, stdout=subprocess.DEVNULL,
                   env={"PYTHONPATH": str(ROOT / "build" / "python"), **os.environ})
    return json.loads((out / "experiment.json").read_text())["tables"][0]


def measure(options):
    """Prints the table; returns the figures that are missed."""
    print("| projected | method | bound, 1e-6 px | bound over scatter | log10 FAP | expected | found | without signal: "
          "bound over scatter | alarms | p of FAPs |\n" + "|---" * 10 + "|")
    wrong = []
    for number, (kind, (projected, methods)) in enumerate(CASES.items()):
        simulator = toliman.Simulator(scene := scene_of(projected, **options.groups))
        layout = toliman.CAE(simulator).info.layout
        if layout != "core":
            wrong.append(f"layout {layout}: must be core")
        table = experiment(options, f"core-{number}", scene, methods)
        for row, none in zip(table["ladder"], table["controls"]):
            print(f"| {kind} | {row['method']} | {1e6 * table['crb_projected_px']:.3f} | {row['efficiency']:.3f} | "
                  f"{row['log10_fap']:.2f} | {row['expected_log10_fap']:.2f} | {row['found']} of {row['seeds']} | "
                  f"{none['efficiency']:.3f} | {none['alarms']} of {none['series']} | {none['ks_p']:.2f} |", flush=True)
            if none["efficiency"] < options.efficiency or none["alarms"] > 1 or row["found"] < row["seeds"]:
                wrong.append(f"{kind} projected, {row['method']}: does not reach the bound, misses a planet, or false alarms")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "build" / "core", help="of the experiments")
    parser.add_argument("--seeds", type=int, default=20, help="seeds of the noise")
    parser.set_defaults(groups={}, efficiency=EFFICIENCY)  # the short form has others
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    logging.getLogger("toliman").setLevel(logging.ERROR)
    began = time.monotonic()
    wrong = measure(options)
    print(f"\n{time.monotonic() - began:.0f} s\n" + "\n".join(wrong))
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
