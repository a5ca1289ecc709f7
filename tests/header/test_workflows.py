"""Tests of the files that a public host reads: each step of a workflow is a target of the Makefile, each parser that
SECURITY.md limits has its fuzz target and the reverse, and CITATION.cff and CODEOWNERS name what exists."""
import pathlib
import re
import unittest

TOP = pathlib.Path(__file__).resolve().parents[2]
FIRST = ("apt-get update && apt-get install -y git make "
         "&& git config --global --add safe.directory '*'")  # on an empty Debian, whose checkout has another owner


def read(path):
    return (TOP / path).read_text(encoding="utf-8")


class Workflows(unittest.TestCase):
    def test_steps_are_targets(self):
        makefile = read("Makefile")
        targets = set(re.findall(r"(?m)^([a-z0-9-]+(?: [a-z0-9-]+)*): .*##", makefile))
        targets = {word for line in targets for word in line.split()}
        files = sorted((TOP / ".github/workflows").glob("*.yml"))
        self.assertEqual([path.name for path in files], ["check.yml", "nightly.yml", "release.yml", "weekly.yml"])
        for path in files:
            text = path.read_text(encoding="utf-8")
            named = re.findall(r"target: ([a-z0-9-]+)\}", text)
            for words in re.findall(r"target: \[(.*?)\]", text):
                named += [word.split()[0] for word in words.split(", ")]
            for run in re.findall(r"run: (.*)", text):
                if run not in (FIRST, "make ${{matrix.target}}"):
                    self.assertRegex(run, r"^make [a-z0-9-]+$", path.name)
                    named.append(run.split()[1])
            self.assertTrue(named, path.name)
            self.assertLessEqual(set(named), targets, path.name)

    def test_every_campaign_is_scheduled(self):
        """Or is a study of hours, or needs another machine."""
        campaigns = set(re.search(r"CAMPAIGNS = (.*)", read("Makefile")).group(1).split())
        text = "".join(path.read_text(encoding="utf-8") for path in (TOP / ".github/workflows").glob("*.yml"))
        scheduled = set(re.findall(r"[a-z0-9-]+", text))
        self.assertEqual(campaigns - scheduled, {"science", "planets", "camera", "cosmic", "core", "masks", "chapter", "budget",
                                                 "mutants", "reproducible", "debian13"})


class Files(unittest.TestCase):
    # promise: parsers-are-safe
    def test_each_parser_has_limits_and_a_target(self):
        lists = re.findall(r"set\((?:library|program)_targets ([^)]*)\)", read("tests/fuzz/CMakeLists.txt"))
        targets = sorted(" ".join(lists).split())
        rows = re.findall(r"(?m)^\|[^|]*\|[^|]*\| (\w+) \|$", read("SECURITY.md"))
        self.assertEqual(sorted(rows), targets)
        described = re.findall(r"(?m)^\| ((?:\w+, )*\w+) \|", read("tests/fuzz/README.md"))
        self.assertEqual(sorted(word for row in described for word in row.split(", ") if row != "target"), targets)

    def test_citation(self):
        citation = dict(re.findall(r"(?m)^([a-z-]+): (.+)$", read("CITATION.cff")))
        version = re.search(r"project\(toliman VERSION ([0-9.]+)", read("CMakeLists.txt")).group(1)
        self.assertEqual(citation["version"], version)
        self.assertEqual(citation["license"], "BSD-3-Clause")
        self.assertIn("BSD 3-Clause", read("LICENSE"))
        self.assertIn("## [" + version + "]", read("CHANGELOG.md"))

    def test_owners(self):
        for line in read(".github/CODEOWNERS").splitlines():
            for path in re.findall(r"(?:^|\s)(/\S+)", line.split("#")[0]):
                self.assertTrue((TOP / path[1:]).is_dir(), path)


if __name__ == "__main__":
    unittest.main()
