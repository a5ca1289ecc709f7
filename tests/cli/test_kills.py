"""Commands that are killed: the short form of kills_campaign.py, and what a kill leaves."""
import pathlib
import tempfile
import unittest

import kills_campaign as campaign
from kills_campaign import measure, with_options
from program import ProgramTest, long


class Kills(unittest.TestCase):
    def check(self, job, make, kills):
        with tempfile.TemporaryDirectory() as inputs:
            make(pathlib.Path(inputs))
            tally = measure(job, pathlib.Path(inputs), kills, 0)
        print(tally.text(job.command[0]))
        self.assertEqual(tally.faults, 0)
        self.assertGreater(tally.absent, 0)

    # promises: killed-merges-begin-again, kills-leave-no-half-result
    def test_merge(self):
        self.check(campaign.MERGE, lambda folder: campaign.states(folder, 5), 3)

    # promises: killed-trainings-resume, kills-leave-no-half-result
    @long
    def test_bank(self):
        self.check(with_options(campaign.BANK, "--places", "1", "--steps", "60"), campaign.bank_scene, 2)

    # promises: killed-calibrations-resume, kills-leave-no-half-result
    @long
    def test_calibrate(self):
        self.check(with_options(campaign.CALIBRATE, "--free", "scale zernike_5-8"),
                   lambda folder: campaign.calibration(folder, campaign.TELESCOPE, 4), 3)


    # promise: kills-leave-no-half-result
    def test_others(self):
        for name, kills in (("simulate --session", 3), ("planet", 3), ("planet --map", 3), ("run", 1)):
            with self.subTest(name):
                job, make, _, _ = campaign.JOBS[name]
                self.check(job, make, kills)


class Left(ProgramTest):
    # promise: killed-merges-begin-again
    def test_a_folder_of_a_merge_that_was_killed(self):
        """It is removed by the next merge, and nothing else is."""
        campaign.states(self.folder, 2)
        for name, files in (("merged.0.tmp", ("ledger.tlml.tmp",)), ("merged.1.tmp", ("ledger.tlml", "mine/text"))):
            for file in files:
                path = self.folder / name / file
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch()
        self.run_program("merge", "state0", "state1", "--out", "merged")
        self.assertTrue((self.folder / "merged/ledger.tlml").exists())
        self.assertEqual([path.relative_to(self.folder).as_posix() for path in self.folder.glob("merged.*.tmp/*")],
                         ["merged.1.tmp/mine"])
        for name in ("merged", "merged/"):
            self.refuse(6, "merged: ", arguments=("merge", "state0", "state1", "--out", name))
        self.run_program("merge", "state0/", "state1/", "--out", "other/")
        self.assertTrue((self.folder / "other/ledger.tlml").exists())

    def test_temporaries_of_a_tracker(self):
        campaign.states(self.folder, 2)
        for name in ("ledger.tlml.tmp", "checkpoint.tlmc.tmp", "setup.tlms.new"):
            (self.folder / "state0" / name).touch()
        self.succeed("rebuild", "state0")
        self.assertEqual(sorted(path.name for path in (self.folder / "state0").iterdir()),
                         ["checkpoint.tlmc", "ledger.tlml", "setup.tlms", "streams.txt"])


if __name__ == "__main__":
    unittest.main()
