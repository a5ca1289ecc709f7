"""Tests the checks of layers, words, format and headers with incorrect trees: each must name the right line. Also tests
which files they check, with and without git."""
import os
import shutil
import subprocess
import sys
import unittest
import unittest.mock

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from copied_tree import TOP, CopiedTree

CHECKS = os.path.join(TOP, "tools/check")


class Tree(CopiedTree):
    def run_check(self, check, *arguments, **environment):
        return self.run_tool(os.path.join("tools/check", check), *arguments, **environment)

    def accepts(self, check, name, text, *arguments):
        self.write(name, text)
        self.assertEqual(self.run_check(check, *arguments), (0, ""))

    def refuses(self, check, name, text, place, *arguments):
        self.write(name, text)
        code, output = self.run_check(check, *arguments)
        self.assertEqual(code, 1, output)
        self.assertIn(place, output)
        os.remove(os.path.join(self.top, name))


class Files(Tree):
    """A tree with a build folder and with files that .gitignore names."""

    def setUp(self):
        super().setUp()
        self.write(".gitignore", "/build/\n*.run/\n__pycache__/\n*.log\n")
        self.good = [".gitignore", "docs/build/a.md", "docs/x.run", "lib/base/a.cpp", "lib/\u00e4 b.cpp"]
        for name in self.good[1:]:
            self.write(name, "good\n")
        for name in ("build/a.md", "a.run/a.md", "lib/__pycache__/a.md", "lib/a.log", "out/a.md", "other/a.md"):
            self.write(name, "/" + "root/a\n")
        self.write("out/CMakeCache.txt", "")
        self.git("init", "--quiet", "other")
        os.symlink("nowhere", os.path.join(self.top, "lib/dangling"))

    def git(self, *arguments):
        subprocess.run(["git", "-C", self.top, *arguments], check=True)

    def expect_good(self, **environment):
        run = subprocess.run([sys.executable, os.path.join(CHECKS, "tree.py"), self.top], stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, encoding="utf-8", env={**os.environ, **environment})
        self.assertEqual((run.returncode, run.stdout.splitlines()), (0, self.good))
        self.assertEqual(self.run_check("words", **environment), (0, ""))

    def test_without_git(self):
        self.expect_good()

    def test_repository(self):
        self.git("init", "--quiet")
        self.git("add", "lib")
        self.expect_good()
        self.write(".git/info/exclude", "lib/base\n")
        self.write("lib/base/b.cpp", "/" + "root/a\n")
        self.expect_good()

    def test_repository_that_git_cannot_read(self):
        self.write(".git", "gitdir: nowhere\n")
        self.expect_good()

    def test_repository_of_another_user(self):
        self.git("init", "--quiet")
        self.expect_good(GIT_TEST_ASSUME_DIFFERENT_OWNER="1")

    def test_git_is_not_installed(self):
        self.git("init", "--quiet")
        tools = os.path.join(self.top, "build")
        for tool in ("python3", "env"):
            os.symlink(shutil.which(tool), os.path.join(tools, tool))
        self.expect_good(PATH=tools)

    def test_this_tree_is_the_same_without_git(self):
        if not os.path.exists(os.path.join(TOP, ".git")):
            self.skipTest("no repository")
        sys.path.append(CHECKS)
        import tree
        with_git = tree.files(TOP)
        with unittest.mock.patch.object(tree, "known_to_git", lambda top: None):
            self.assertEqual(tree.files(TOP), with_git)

    def test_unreadable_files_are_reported(self):
        for check, *before in (["layers"], ["words"], ["format"], ["bindings"], ["headers", "."], ["exports", "."]):
            run = subprocess.run([os.path.join(CHECKS, check), *before, "/nowhere"], stdout=subprocess.PIPE,
                                 stderr=subprocess.STDOUT, universal_newlines=True)
            self.assertEqual((run.returncode, run.stdout), (1, f"/nowhere: not a folder\n{check}: 1 complaint\n"))
        for check in ("bindings", "exports"):  # a tree without headers
            code, output = self.run_check(check, *["."] * (check == "exports"))
            self.assertEqual((code, "Traceback" in output), (1, False), output)


class Layers(Tree):
    def test_good_includes(self):
        self.accepts("layers", "lib/optics/a.cpp", '#include <vector>\n#include "kernels/b.hpp"\n#include "base/c.hpp"\n')
        self.accepts("layers", "lib/optics/b.cpp", '#include "scene/a.hpp"\n')
        self.accepts("layers", "lib/backend/blas.cpp", "#include <cblas.h>\n#include <lapacke.h>\n")
        self.accepts("layers", "lib/backend/file.cpp", "#include <unistd.h>\n")
        self.accepts("layers", "lib/backend/store.cpp", "#include <fcntl.h>\n#include <sys/file.h>\n")
        self.accepts("layers", "lib/kernels/random.hpp", '#include <cmath>\n#include <Random123/philox.h>\n')
        self.accepts("layers", "lib/kernels/a.isa.cpp", '#include <immintrin.h>\n#include "base/view.hpp"\n')
        self.accepts("layers", "lib/api/a.cpp", '#include <toliman/sim.h>\n#include "cae/a.hpp"\nextern "C" int f();\n')
        self.write("lib/base/nearest_word.hpp", "")
        self.accepts("layers", "tools/cli/options/a.cpp", '#include "base/nearest_word.hpp"\n')
        self.refuses("layers", "tools/mpi/a.cpp", '#include "base/nearest_word.hpp"\n', "tools/mpi/a.cpp:1: ")
        self.accepts("layers", "lib/kernels/a.cpp", '#include "base/constants.hpp"\n')
        self.accepts("layers", "tools/cli/a.cpp", '#include <toliman/sim.h>\n#include "b.hpp"\n// extern "C"\n')
        self.accepts("layers", "lib/base/a.cpp", "/*\n#include <zlib.h>\n*/\n")

    def test_modules_of_the_library(self):
        for module, header in (("optics", "cae/a.hpp"), ("optics", "information/a.hpp"), ("cae", "linear/a.hpp"), ("linear", "period/a.hpp"),
                             ("period", "track/a.hpp"), ("track", "cae/a.hpp"), ("backend", "kernels/a.hpp"),
                             ("base", "backend/a.hpp"), ("kernels", "base/error.hpp"), ("api", "kernels/a.hpp"),
                             ("optics", "api/a.hpp"), ("scene", "optics/a.hpp"), ("cae", "scene/a.hpp"),
                             ("base", "frame/a.hpp"), ("frame", "backend/a.hpp"),
                             ("base", "error.hpp"), ("attic", "base/error.hpp")):
            name = "lib/%s/a.cpp" % module
            self.refuses("layers", name, '\n#include "%s"\n' % header, name + ":2: " + header)

    def test_folders_of_a_module(self):
        self.accepts("layers", "lib/period/noise/a.cpp", '#include "period/noise/b.hpp"\n#include "period/batch/c.hpp"\n#include "period/d.hpp"\n')
        self.accepts("layers", "lib/period/batch/a.cpp", '#include "period/stream/b.hpp"\n#include "kernels/c.hpp"\n')
        for name, header, why in (("period/stream/a.cpp", "period/b.hpp", "lib/period/stream must not include lib/period"),
                                  ("period/batch/a.cpp", "period/noise/b.hpp", "lib/period/batch must not include lib/period/noise"),
                                  ("period/a.cpp", "period/noise/b.hpp", "lib/period must not include lib/period/noise"),
                                  ("optics/deep/a.cpp", "optics/b.hpp", "lib/optics/deep is not a known folder")):
            self.refuses("layers", "lib/" + name, '#include "%s"\n' % header, "lib/%s:1: %s: %s" % (name, header, why))

    def test_modules_of_the_program(self):
        self.accepts("layers", "tools/cli/commands/a.cpp", '#include "frames/b.hpp"\n#include "commands/c.hpp"\n')
        for module, header in (("common", "frames/a.hpp"), ("series", "downlink/a.hpp"), ("run", "commands/a.hpp")):
            name = "tools/cli/%s/a.cpp" % module
            self.refuses("layers", name, '\n#include "%s"\n' % header, name + ":2: " + header)

    def test_system_headers(self):
        for name, header in (("lib/kernels/a.cpp", "vector"), ("lib/kernels/a.cpp", "immintrin.h"),
                             ("lib/kernels/a.cpp", "Random123/philox.h"), ("lib/optics/a.cpp", "fftw3.h"),
                             ("lib/base/a.cpp", "toliman/base.h"), ("lib/api/a.cpp", "zlib.h"),
                             ("lib/period/a.cpp", "unistd.h"), ("lib/backend/zip.cpp", "fcntl.h")):
            self.refuses("layers", name, "#include <%s>\n" % header, name + ":1: " + header)

    def test_one_file_per_third_party_library(self):
        self.refuses("layers", "lib/backend/a.cpp", "#include <zlib.h>\n#include <fftw3.h>\n", "lib/backend/a.cpp:2: ")
        self.write("lib/backend/fft.cpp", "#include <fftw3.h>\n")
        self.refuses("layers", "lib/backend/other.cpp", "\n#include <fftw3.h>\n", "lib/backend/other.cpp:2: fftw3.h")

    def test_outside_lib_sees_public_headers_only(self):
        self.write("lib/base/error.hpp", "")
        for folder in ("tools/cli", "examples/c", "bindings/python", "tests/unit", "tests/golden"):
            for header in ("base/error.hpp", "../../lib/base/error.hpp"):
                name = folder + "/a.c"
                self.refuses("layers", name, '#include "%s"\n' % header, name + ":1: " + header)
        self.accepts("layers", "tools/bench/a.cpp", '#include "base/error.hpp"\n')
        self.refuses("layers", "include/toliman/a.h", '#include "toliman/b.h"\n', "include/toliman/a.h:1: ")

    def test_extern_c(self):
        for name in ("lib/optics/a.cpp", "lib/base/a.hpp", "tools/cli/a.cpp", "include/toliman/a.h"):
            self.refuses("layers", name, 'int a;\nextern "C" {\n}\n', name + ":2: extern")

    def test_sizes(self):
        self.accepts("layers", "lib/base/a.cpp", "\n" * 600)
        self.accepts("layers", "include/toliman/a.h", "\n" * 400)
        self.refuses("layers", "lib/base/a.cpp", "\n" * 601, "lib/base/a.cpp:601: 601 lines")
        self.refuses("layers", "include/toliman/a.h", "\n" * 401, "include/toliman/a.h:401: 401 lines")


class Words(Tree):
    def test_good(self):
        self.accepts("words", "lib/a/b.cpp", 'fail("%zu of %s, 50 % in %lld %-8.3g%% of all");\n')
        self.accepts("words", "README.md", "https://host/work/a include/work/a a/root b/tmp/c todo /tmp\n")

    def test_bad(self):
        for bad in ("/" + "root/a", "/" + "work/a", "in /" + "tmp/a", "/" + "home/me", "see ../" + "shared/A.md",
                    "TO" + "DO: later"):
            self.refuses("words", "docs/a.md", "one\n%s\n" % bad, "docs/a.md:2: ")
        for bad in ("%.3Lg", "%e", "%5i ", "%p"):
            self.refuses("words", "lib/a/b.cpp", 'fail("one %d, %s");\n' % (1, bad), "lib/a/b.cpp:1: ")

    RETIRED = ("The frame is propagated anew.", "Power beside the bound", "Manners of the library", "A remark about the grid",
               "Facts of a network", "What a call came to", "narrow sums are quick", "what the decoder paints", "look_at(frame)",
               "it is denied", "the frames kept back", "Takes back a sample", "the training is taken up", "the house rules",
               "a room of its own", "one a processor", "4 bytes a pixel", "pixel j stands at u", "that stood there", "no series pays",
               "The log hears it", "brought to the disk", "and then goes on", "a hole in the frame", "a ladder of signals",
               "1.3 times of the least", "series is no JSON object", "frames lost behind its end")
    PLAIN = ("there is no file, which is no longer used", "least squares stands for the fit, of the least-squares kind",
             "permission denied", "stands for", "to go on to the next", "a whole mushroom", "the bedside table", "per pixel")

    def test_retired_phrases(self):
        """Each of them is found, on its line, in code, headers and documents."""
        for name in ("lib/a/b.cpp", "include/toliman/a.h", "docs/a.md"):
            self.write(name, "".join("// %s\n" % phrase for phrase in self.RETIRED))
        code, output = self.run_check("words")
        self.assertEqual(code, 1)
        for name in ("lib/a/b.cpp", "include/toliman/a.h", "docs/a.md"):
            for number, phrase in enumerate(self.RETIRED, 1):
                self.assertIn("%s:%d: " % (name, number), output, phrase)

    def test_plain_phrases(self):
        self.accepts("words", "README.md", "\n".join(self.PLAIN))

    def test_tables_of_old_names(self):
        self.accepts("words", "CHANGELOG.md", "| `hole_bytes`: a hole | `zero_run_bytes` |\n")


@unittest.skipUnless(shutil.which("clang-format"), "clang-format is not installed")
class Format(Tree):
    def test_both(self):
        self.write(".clang-format", "BasedOnStyle: LLVM\n")
        self.accepts("format", "lib/base/a.cpp", "int a;\nint b;\n")
        self.refuses("format", "lib/base/a.cpp", "int a;\nint   b;\n", "lib/base/a.cpp:2: ")


class Headers(Tree):
    def test_good(self):
        self.accepts("headers", "include/toliman/a.h", "#define A 1\n", self.top)
        self.accepts("headers", "include/toliman/b.hpp", "class B {};\n", self.top)

    def test_bad(self):
        for text, standard in (("size_t a(void);\n", "-std=c99"), ("int a(void *class);\n", "-std=c++11"),
                               ("typedef int a;\ntypedef int a;\n", "-std=c99"),
                               ("static int a(int b) { return 0; }\n", "-std=c11"),
                               ("#include <toliman/b.h>\n", "-std=c++17")):
            self.refuses("headers", "include/toliman/a.h", text, standard, self.top)

    def test_columns(self):
        """A line of an entry of a manual outside its column, as a formatter leaves it."""
        head, end = "/* A manual.\n *\n", " */\n#define A 1\n"
        self.accepts("headers", "include/toliman/a.h", head + " * Model        y = c +\n *              signal\n"
                     " * Two words    text\n *\n * A paragraph\n * of its own.\n" + end, self.top)
        for text, line in ((" * Axis         amplitudes,\n * across the axis\n", 4), (" * Odds         log10\n *   of it\n", 4),
                           (" * Model        y\n *              = c\n * Noise      white\n", 5)):
            self.refuses("headers", "include/toliman/a.h", head + text + end,
                         f"include/toliman/a.h:{line}: a line of an entry outside the column of its text", self.top)

    def test_missing_compiler(self):
        """Reported, not skipped."""
        tools = os.path.join(self.top, "bin")
        os.mkdir(tools)
        for tool in ("python3", "env", "git", "gcc", "g++", "clang"):
            os.symlink(shutil.which(tool), os.path.join(tools, tool))
        code, output = self.run_check("headers", self.top, PATH=tools)
        self.assertEqual(code, 1, output)
        self.assertIn("clang++ is not installed: run tools/deps/install check", output)


if __name__ == "__main__":
    unittest.main()
