"""The command line of a campaign that has modes: each prints a table and returns what is wrong in it."""
import argparse
import logging
import multiprocessing
import os
import time


def quiet():
    logging.getLogger("toliman").setLevel(logging.ERROR)


def run(doc, modes, sets=None, sets_help=""):
    """Runs the modes that are named, or all. modes: functions of a pool of processes and the options, by name; sets: default of
    the options --sets and --seed; None: there are none. Returns the exit status."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modes", nargs="*", metavar="mode", choices=[[], *modes], help=f"{', '.join(modes)}; all")
    if sets is not None:
        parser.add_argument("--sets", type=int, default=sets, help=sets_help)
        parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=0, help="processes; 0 = one per processor")
    given = parser.parse_args()
    wrong = []
    with multiprocessing.Pool(given.jobs or os.cpu_count(), quiet) as pool:
        for mode in given.modes or modes:
            began = time.monotonic()
            wrong += modes[mode](pool, given)
            print(f"\n{mode}: {time.monotonic() - began:.0f} s\n", flush=True)
    print("\n".join(wrong))
    return bool(wrong)
