#!/usr/bin/env python3
"""Measures what the tests see of the numeric code: changes one line of lib at a time and runs the tests of its module.

A mutant is a copy of one source file with one change: another operator, limit, sign or constant, or a statement less. Its object
replaces the original when the library and the programs of tests/kernel are linked, in a folder outside the build; neither the
sources nor the build change. A test that fails, crashes or runs out of time kills the mutant. A mutant that no test kills shows
a test that is missing, or a change without effect. Changes that do not compile, or to the same code, do not count.

The tests must be built, with an object for each file (TOLIMAN_UNITY=OFF). The journal in FOLDER lets an interrupted run continue; --again runs its survivors again."""
import argparse
import collections
import contextlib
import itertools
import json
import multiprocessing.pool
import os
import pathlib
import random
import re
import resource
import signal
import subprocess
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[2]
# The tests that run each module, as ctest names them.
TESTS = {
    "period": r"(unit|golden)/test_(period.*|fap.*|series|files)$|kernel/test_(power|push|spread)$|bind/test_nuisance$",
    "planet": r"unit/test_(measure|misuse)$|kernel/test_kepler$|bind/test_(planet.*|instruments)$",
    "optics": r"unit/test_(sim.*|pupil|budget|mask|scene)$|kernel/test_(atlas|field|line_filter|orbit|shift|zernike)$",
    "sky": r"unit/test_(sky_api|system|scene)$|kernel/test_(ephemeris.*|kepler|orbit)$|bind/test_(observer|sky|predict.*)$",
    "track": r"unit/test_track.*$|golden/test_files$",
}
MODULES = ("period", "planet")
SILENT = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
MEMORY_KB = 8 << 20
IDLE = 20  # times the limit: the end of a test that waits
NUMBER = r"(?<![\w.'\"])(\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+|\d+)(?![\w.'\"])"
SWAPPED = ((" + ", " - "), (" * ", " / "), (" += ", " -= "), (" *= ", " /= "), (" < ", " <= "), (" > ", " >= "), (" == ", " != "),
           (" && ", " || "), ("true", "false"), ("std::min(", "std::max("), ("std::sin(", "std::cos("), ("++", "--"))
STATEMENT = re.compile(r"\s+(?:(?:break|continue)|[\w.>:()\[\]*+-]+(?: [-+*/|&]?= .*|\(.*\))|\+\+\w+|\w+\+\+);$")

Mutant = collections.namedtuple("Mutant", "file line before after")


def changes(line, ends_statement):
    """The lines that one change makes of a line; ends_statement: the line before it is complete."""
    code = re.sub(r'"(?:\\.|[^"\\])*"', lambda text: "~" * len(text.group()), line)
    code = code[:code.find("//")] if "//" in code else code
    if not code.startswith("    ") or re.match(r"\s*(?:#|static_assert|using|template|friend|\[\[|///?)", code):
        return
    for left, right in SWAPPED + tuple((b, a) for a, b in SWAPPED):
        for match in re.finditer(re.escape(left), code):
            yield line[:match.start()] + right + line[match.end():]
    for match in re.finditer(NUMBER, code):
        other = str(int(match[0]) + 1) if match[0].isdigit() else "(%s * 1.001)" % match[0]
        yield line[:match.start()] + other + line[match.end():]
    for match in re.finditer(r"(?:(?<== )|(?<=return )|(?<=\()|(?<=, ))-(?=[\w(])", code):
        yield line[:match.start()] + line[match.end():]
    value = re.match(r"(.* = |.*return )([\w(][^;{]*);$", code)
    if value and not re.search(r"[&*]\w+ = ", code):
        yield line[:value.end(1)] + "-(" + line[value.start(2):value.end(2)] + ");"
    if ends_statement and STATEMENT.match(code) and code.count("(") == code.count(")"):
        yield re.match(r"\s*", line).group() + ";"


def mutants_of(file):
    """All mutants of a file, in the order of its lines."""
    lines = pathlib.Path(TOP, file).read_text(encoding="utf-8").split("\n")
    for number, line in enumerate(lines):
        for after in changes(line, lines[number - 1].rstrip().endswith((";", "{", "}", ":"))):
            yield Mutant(file, number + 1, line, after)


class Build:
    """The commands of the build that compile one file and link one program, with other paths."""

    def __init__(self, folder):
        self.folder = os.path.realpath(folder)
        self.targets = [line.split(": ")[0] for line in self.ninja("targets", "all")]
        self.library = next(name for name in self.targets if re.fullmatch(r"lib/libtoliman\.so\.\d+\.\d+", name))

    def ninja(self, *what):
        """Lines that a tool of ninja prints."""
        return subprocess.run(["ninja", "-C", self.folder, "-t", *what], capture_output=True, text=True,
                              check=True).stdout.splitlines()

    def command(self, target):
        """The command that makes a target."""
        return self.ninja("commands", "-s", target)[-1]

    def run(self, command, folder):
        """Whether a command succeeds in the build folder."""
        return subprocess.run(command, shell=True, cwd=self.folder, env=dict(os.environ, CCACHE_DISABLE="1", TMPDIR=folder),
                              **SILENT).returncode == 0

    def compile(self, file, source, folder):
        """Compiles a source in place of a file, quickly: {object of the build: its replacement}, none if it fails."""
        made, objects = {}, re.compile(r"CMakeFiles/toliman_\w+\.dir/%s\.o" % re.escape(file))  # one for each instruction set
        for number, name in enumerate(filter(objects.fullmatch, self.targets)):
            made[name] = os.path.join(folder, "%d.o" % number)
            command = re.sub(r"-MD -MT \S+ -MF \S+", "", self.command(name)).replace(" -O3 -DNDEBUG ", " -O1 -DNDEBUG ")
            command = re.sub(r"-c \S+$", "-c " + source, command.replace("-o " + name, "-o " + made[name]))
            if not self.run(command, folder):
                return {}
        return made

    def link(self, target, made, folder):
        """Links a target with other objects; those of lib come first where it is an archive. Returns its path, or None."""
        path = os.path.join(folder, os.path.basename(target))
        archive = " lib/libtoliman_inside.a"
        command = self.command(target).replace(" -o " + target, " -o " + path).replace(
            archive, " ".join(["", *made.values()]) + archive)
        for name, other in made.items():
            command = command.replace(" %s " % name, " %s " % other)
        return path if self.run(command, folder) else None


class Test:
    """A test of ctest, and the processor seconds that it takes."""

    def __init__(self, entry, build):
        properties = {item["name"]: item["value"] for item in entry["properties"]}
        self.name, self.command, self.build = entry["name"], entry["command"], build
        self.folder, self.seconds = properties.get("WORKING_DIRECTORY", build.folder), 0.0
        self.variables = dict(item.split("=", 1) for item in properties.get("ENVIRONMENT", ()))

    def passes(self, limit, library, program=None):
        """Whether the test passes in processor seconds, with another library, or another program of tests/kernel."""
        variables = dict(os.environ, OPENBLAS_NUM_THREADS="1", **{**self.variables, "TOLIMAN_LIBRARY": library},
                         LD_LIBRARY_PATH=os.path.dirname(library))
        command = [program] + self.command[1:] if program else self.command
        within = 'ulimit -v %d; ulimit -t %d; exec "$@"' % (MEMORY_KB, limit)
        process = subprocess.Popen(["/bin/sh", "-c", within, "sh", *command], env=variables, cwd=self.folder,
                                   start_new_session=True, **SILENT)
        try:
            return process.wait(timeout=IDLE * limit) == 0
        except subprocess.TimeoutExpired:
            return False
        finally:  # also what the test has started
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def tests_of(build, pattern, limit):
    """The tests that pass within the limit, the fastest first; prints the others."""
    listed = json.loads(subprocess.run(["ctest", "--test-dir", build.folder, "-R", pattern, "--show-only=json-v1"],
                                       capture_output=True, check=True).stdout)
    tests, left_out = [], []
    for test in (Test(entry, build) for entry in listed["tests"] if "command" in entry):
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        passed = test.passes(limit, os.path.join(build.folder, build.library))
        test.seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        (tests if passed else left_out).append(test)
    if left_out:
        print("without %s: failed, or took more than %g s" % (", ".join(test.name for test in left_out), limit))
    return sorted(tests, key=lambda test: test.seconds)


def compiled(mutant, after, build, folder):
    """Compiles the file of a mutant, before or after its change: objects as of Build.compile, and what they contain."""
    lines = pathlib.Path(TOP, mutant.file).read_text(encoding="utf-8").split("\n")
    if after:
        lines[mutant.line - 1] = mutant.after
    source = os.path.join(folder, os.path.basename(mutant.file))
    pathlib.Path(source).write_text("\n".join(lines), encoding="utf-8")
    made = build.compile(mutant.file, source, folder)
    return made, [pathlib.Path(path).read_bytes() for path in made.values()]


def verdict_of(mutant, build, tests, limit, originals):
    """'broken': does not compile; 'same': the same code; the test that kills it; '': none does."""
    with tempfile.TemporaryDirectory() as folder:
        if mutant.file not in originals:
            originals[mutant.file] = compiled(mutant, False, build, folder)[1]
        made, contents = compiled(mutant, True, build, folder)
        library = build.link(build.library, made, folder) if made else None
        if library is None or contents == originals[mutant.file]:
            return "same" if library else "broken"
        for test in tests:
            own = test.name.startswith("kernel/")
            program = build.link("bin/" + os.path.basename(test.command[0]), made, folder) if own else None
            if not test.passes(3 * limit, library, program):
                return test.name
        return ""


def study(mutants, known, count, jobs, run):
    """The verdicts of the first `count` mutants that compile to other code, known ones first; run: verdict of a mutant."""
    found, rest = {}, iter(mutants)
    with multiprocessing.pool.ThreadPool(jobs) as pool:
        while batch := list(itertools.islice(rest, count - len(found))):
            verdicts = pool.map(lambda one: known[one] if one in known else run(one), batch, 1)
            found.update((mutant, verdict) for mutant, verdict in zip(batch, verdicts) if verdict not in ("broken", "same"))
    return found


def report(found):
    """Prints a table of the files, and the survivors."""
    print("%-36s %8s %8s %10s" % ("file", "mutants", "killed", "survivors"))
    for file in sorted({mutant.file for mutant in found}) + [None]:
        verdicts = [verdict for mutant, verdict in found.items() if file in (None, mutant.file)]
        killed = sum(verdict != "" for verdict in verdicts)
        print("%-36s %8d %8d %10d" % (file or "all", len(verdicts), killed, len(verdicts) - killed))
    for mutant in sorted(mutant for mutant, verdict in found.items() if verdict == ""):
        print("%s:%d:\n  -%s\n  +%s" % (mutant.file, mutant.line, mutant.before.strip(), mutant.after.strip()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="*", default=MODULES, help="%s, or files of lib" % ", ".join(TESTS))
    parser.add_argument("--build", default="build-release", help="with the library and the tests")
    parser.add_argument("--folder", default="build-mutants", help="of the journal")
    parser.add_argument("--count", type=int, default=40, help="mutants of each module or file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutants at a time")
    parser.add_argument("--limit", type=float, default=10, help="leave out slower tests, processor seconds")
    parser.add_argument("--again", action="store_true", help="run the survivors of the journal again")
    given = parser.parse_args()
    build = Build(given.build)
    os.makedirs(given.folder, exist_ok=True)
    path = pathlib.Path(given.folder, "journal")
    path.touch()
    known = {Mutant(*entry[:4]): entry[4] for entry in map(json.loads, path.read_text(encoding="utf-8").splitlines())}
    known = {mutant: verdict for mutant, verdict in known.items() if verdict or not given.again}
    with path.open("a", encoding="utf-8") as journal:
        for what in given.what:
            module = what.split("/")[1] if "/" in what else what
            sources = [pathlib.Path(TOP, what)] if "/" in what else pathlib.Path(TOP, "lib", what).rglob("*.cpp")
            files = sorted(str(source.relative_to(TOP)) for source in sources)
            mutants = [mutant for file in files for mutant in mutants_of(file)]
            random.Random("%d %s" % (given.seed, what)).shuffle(mutants)
            tests = tests_of(build, TESTS[module], given.limit)

            def run(mutant, tests=tests, originals={}):  # of this module
                verdict = verdict_of(mutant, build, tests, given.limit, originals)
                journal.write(json.dumps([*mutant, verdict]) + "\n")
                journal.flush()
                return verdict

            print("\n%s: %d tests, %.0f s; %d changes" % (what, len(tests), sum(test.seconds for test in tests), len(mutants)),
                  flush=True)
            report(study(mutants, known, given.count, given.jobs, run))


if __name__ == "__main__":
    main()
