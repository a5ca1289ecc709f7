"""Tests man pages against --help and the headers, and completion in bash, zsh and fish. TOLIMAN_BUILD is the build
folder."""
import functools
import gzip
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

BUILD = pathlib.Path(os.environ["TOLIMAN_BUILD"])
ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM, SHARE = BUILD / "bin" / "toliman", BUILD / "share"
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")


@functools.lru_cache(None)
def help_of(*words):
    return subprocess.run([PROGRAM, *words, "--help"], capture_output=True, text=True, check=True).stdout


def commands():
    """Names of the subcommands, from the overview of --help."""
    return re.findall(r"^  (\w+) {2,}", help_of().split("Subcommands:\n")[1], re.M)


def listed(text):
    """Options listed by --help."""
    return set(re.findall(r"^ +(?:-\w,)?(--[a-z][a-z0-9-]*)", text[text.index("\nOptions:"):], re.M))


def roff(page):
    with gzip.open(SHARE / "man" / f"man{page[-1]}" / f"{page}.gz", "rt", encoding="utf-8") as stream:
        return stream.read()


def section(page, name):
    return roff(page).split(f".SH {name}\n")[1].split("\n.SH ")[0].replace("\\-", "-").replace("\\e", "\\")


class Pages(unittest.TestCase):
    def test_every_command_has_a_page(self):
        self.assertGreater(len(commands()), 14)
        pages = {f"toliman-{name}.1.gz" for name in commands()} | {"toliman.1.gz"}
        if (BUILD / "bin" / "toliman-mpi").is_file():
            pages.add("toliman-mpi.1.gz")
        self.assertEqual({path.name for path in (SHARE / "man" / "man1").iterdir()}, pages)
        for name in commands():
            self.assertIn(f"toliman-{name}", section("toliman.1", "COMMANDS"))

    def test_options_match_help(self):
        for name in ([], *([name] for name in commands())):
            page = "-".join(["toliman", *name]) + ".1"
            heads = [line for line in section(page, "OPTIONS").splitlines() if line.startswith("\\fB-")]
            options = {re.search(OPTION, head.replace("\\fB", " ")).group() for head in heads}
            self.assertEqual(options, listed(help_of(*name)), page)
            for tail in (ROOT / "tools" / "man").glob(f"{page[:-2]}.tail"):
                named = set(OPTION.findall(re.sub(r"\\(?=-)", "", tail.read_text())))
                self.assertLessEqual(named, listed(help_of(*name)) | {"--strict", "--clock"}, tail)

    def test_examples_and_texts_match_help(self):
        for name in commands():
            page, text = f"toliman-{name}.1", help_of(name)
            for line in re.findall(r"^  (toliman .*)", text.split("\nUsage:")[0], re.M):
                self.assertIn(line, roff(page).replace("\\-", "-"))
            words = text.split("\nUsage:")[0].partition("\n")[2].replace("`", "").split()
            body = re.sub(r"\\f.|\\&", "", roff(page).replace("\\-", "-").replace("\\e", "\\")).split()
            missing = [word for word in words if word not in body and not word.startswith("Example")]
            self.assertEqual(missing, [], page)

    @unittest.skipUnless((BUILD / "bin" / "toliman-mpi").is_file(), "built without MPI")
    def test_page_of_mpi(self):
        done = subprocess.run([BUILD / "bin" / "toliman-mpi", "--help"], capture_output=True, text=True, check=True,
                              env={**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})
        heads = OPTION.findall(section("toliman-mpi.1", "OPTIONS"))
        self.assertEqual(set(heads), listed(done.stdout) - {"--help", "--version"})

    @unittest.skipUnless(shutil.which("man"), "no man")
    def test_man_reports_no_warnings(self):
        for path in (SHARE / "man").glob("man?/*.gz"):
            done = subprocess.run(["man", "--warnings", "-E", "UTF-8", "-l", path], capture_output=True, text=True,
                                  env={**os.environ, "LC_ALL": "C.UTF-8", "MANWIDTH": "200", "MANROFFSEQ": ""})
            self.assertEqual((done.returncode, done.stderr), (0, ""), path)
            self.assertIn("NAME", done.stdout)


class Library(unittest.TestCase):
    def test_names_match_the_headers(self):
        page, symbols = roff("libtoliman.3").replace("\\-", "-"), (ROOT / "lib/api/toliman.sym").read_text()
        headers = {path.name for path in (ROOT / "include/toliman").glob("*.h*")} - {"export.h", "version.h.in"}
        self.assertEqual(set(re.findall(r"toliman/(\w+\.hp*)\b", page)), headers)
        creates = set(re.findall(r"(toliman_\w+_create\w*);", symbols)) - {"toliman_sim_create_json"}
        named = set(re.findall(r"\.BR (toliman_\w+)", page)) - {"toliman_status"}
        self.assertLessEqual(creates, named)
        self.assertLessEqual(named, set(re.findall(r"(toliman_\w+);", symbols)))

    def test_example_runs(self):
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "example.c"
            source.write_text(section("libtoliman.3", "EXAMPLE").split(".nf\n")[1].split(".fi")[0])
            subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", source, "-o", source.with_suffix(""),
                            f"-I{ROOT}/include", f"-I{BUILD}/include", f"-L{BUILD}/lib", "-ltoliman",
                            f"-Wl,-rpath,{BUILD}/lib"], check=True)
            done = subprocess.run([source.with_suffix("")], capture_output=True, text=True, check=True)
            self.assertAlmostEqual(float(done.stdout.split()[1]), 10, delta=0.05)  # a square wave of period 10


class Completion:
    """What each shell completes; complete() returns the completions of the last word, of which = and , are ends."""

    @staticmethod
    def checked():
        """Commands whose options and values are compared, of shells that start slowly."""
        return ["encode", "period", "predict"]

    def run_shell(self, *command):
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=True, timeout=60,
                              cwd=self.folder, env={**os.environ, "HOME": str(self.folder), "TERM": "dumb"})
        self.assertEqual(done.stderr, "")
        return done.stdout

    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.folder = pathlib.Path(kept.name)

    def test_subcommands(self):
        self.assertLessEqual({*commands(), "help", "--version", "--progress"}, set(self.complete("toliman", "")))
        self.assertEqual(self.complete("toliman", "p"), sorted(name for name in commands() if name.startswith("p")))
        self.assertEqual(self.complete("toliman", "--progress=json", "pe"), ["period"])
        self.assertEqual(self.complete("toliman", "help", "tra"), ["track", "train"])

    def test_options_of_every_command(self):
        for name in self.checked():
            self.assertEqual(set(OPTION.findall(" ".join(self.complete("toliman", name, "--")))),
                             listed(help_of(name)) | {"--progress"}, name)
        self.assertEqual(self.complete("toliman", "run", "chapter.json", "--se"), ["--seed"])

    def test_fixed_values(self):
        for name in self.checked():
            for option, values in re.findall(r"(--[a-z-]+) [^ \n{]*:\{([^}]*)\}", help_of(name)):
                self.assertEqual(self.complete("toliman", name, option, ""), sorted(values.split(",")), (name, option))
        self.assertEqual(self.complete("toliman", "period", "--fap", "ba"), ["baluev"])
        self.assertEqual(self.complete("toliman", "train", "--mode="), ["tied", "unsupervised"])
        self.assertEqual(self.complete("toliman", "train", "--mode=u"), ["unsupervised"])
        self.assertEqual(self.complete("toliman", "predict", "--without", "parallax,l"), ["parallax,light_time"])
        self.assertEqual(self.complete("toliman", "--progress", ""), ["auto", "json", "none"])

    def test_files_are_left_to_the_shell(self):
        for words in (("run", ""), ("run", "cha"), ("run", "--out", ""), ("encode", "--weights=")):
            self.assertEqual(self.complete("toliman", *words), [])


class Bash(Completion, unittest.TestCase):
    checked = staticmethod(commands)

    def complete(self, *words):
        typed = [part for word in words for part in (re.split("(=)", word) if "=" in word else [word])]
        while "" in typed[:-1]:
            typed.remove("")
        typed[0] = str(PROGRAM)
        script = ('. "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); "$(complete -p toliman | '
                  'sed \'s/.*-F \\([^ ]*\\).*/\\1/\')" "$1"; printf "%s\\n" "${COMPREPLY[@]}"')
        return sorted(self.run_shell("bash", "--norc", "-euc", script, "bash",
                                     SHARE / "bash-completion/completions/toliman", *typed).split())

    def test_default(self):
        shown = subprocess.run(["bash", "--norc", "-c", '. "$1"; complete -p toliman', "bash",
                                SHARE / "bash-completion/completions/toliman"], capture_output=True, text=True, check=True)
        self.assertIn("-o default", shown.stdout)


@unittest.skipUnless(shutil.which("zsh"), "needs zsh")
class Zsh(Completion, unittest.TestCase):
    # A terminal in which Tab prints the matches; $1: the folder of _toliman, $2: the line.
    SCRIPT = r'''
        zmodload zsh/zpty
        zpty z zsh -f -i
        zpty -w z "PS1= PS2=; stty -echo; fpath=(${(q)1} \$fpath); autoload -Uz _toliman"
        zpty -w z 'zle -C probe complete-word _toliman; bindkey "^I" probe; _files() { }'
        zpty -w z 'compadd() { local -a hits; builtin compadd -O hits "$@"; print -r -- "" "HIT $hits" }'
        zpty -w z 'finish() { print -l "" DONE }; zle -N finish; bindkey "^T" finish; print READY'
        while zpty -r z text; do [[ $text == *READY* ]] && break; done
        zpty -w -n z "$2"$'\t\x14'
        while zpty -r z text && [[ $text != *DONE* ]]; do
            [[ $text == *HIT* ]] && print -r -- ${${text##*HIT}%%$'\r'*}
        done
        true'''

    def complete(self, *words):
        line = " ".join(map(shlex.quote, [str(PROGRAM), *words[1:-1]])) + f" {words[-1]}"
        shown = self.run_shell("zsh", "-fc", self.SCRIPT, "zsh", SHARE / "zsh/site-functions", line)
        head = words[-1][words[-1].find("=") + 1:words[-1].rfind(",") + 1]  # of a list
        return sorted(head + word for word in shown.split())


@unittest.skipUnless(shutil.which("fish"), "needs fish")
class Fish(Completion, unittest.TestCase):
    def shown(self, line):
        script = f"source {SHARE}/fish/vendor_completions.d/toliman.fish; complete -C {shlex.quote(line)}"
        return self.run_shell("fish", "-N", "-c", script)

    def complete(self, *words):
        shown = self.shown(" ".join(map(shlex.quote, [str(PROGRAM), *words[1:-1]])) + f" {words[-1]}")
        return sorted(row.split("\t")[0].split("=")[-1] for row in shown.splitlines())

    def test_descriptions(self):
        self.assertRegex(self.shown(f"{PROGRAM} merg"), r"^merge\tMerge saved sums")


if __name__ == "__main__":
    unittest.main()
