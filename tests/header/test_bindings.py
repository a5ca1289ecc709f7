"""Tests tools/gen and the check of bindings with headers and bindings that disagree."""
import os
import re
import shutil
import subprocess
import tempfile
import unittest

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SYM, BASE, LINEAR, TRACK, PERIOD = ("lib/api/toliman.sym", "include/toliman/base.h", "include/toliman/linear.h",
                                    "include/toliman/track.h", "include/toliman/period.h")
FORTRAN, PYTHON = "bindings/fortran/toliman.f90", "bindings/python/toliman/_raw.py"
RESULTS, SIZES = "bindings/python/toliman/_results.py", "lib/api/struct_sizes.hpp"
LAYOUT, NETWORK = "lib/cae/layout.hpp", "bindings/python/toliman/report/_network.py"


class Bindings(unittest.TestCase):
    def setUp(self):
        self.top = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.top)
        for name in ("CMakeLists.txt", SYM, "tools/gen/shapes", "tools/gen/toliman.f90.in", FORTRAN, PYTHON, RESULTS,
                     SIZES, LAYOUT, NETWORK):
            os.makedirs(os.path.dirname(os.path.join(self.top, name)), exist_ok=True)
            shutil.copy(os.path.join(TOP, name), os.path.join(self.top, name))
        shutil.copytree(os.path.join(TOP, "include"), os.path.join(self.top, "include"))

    def change(self, name, before, after):
        path = os.path.join(self.top, name)
        with open(path, encoding="utf-8") as stream:
            text = stream.read()
        self.assertIn(before, text)
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(text.replace(before, after, 1))

    def run_tool(self, tool):
        run = subprocess.run([os.path.join(TOP, tool), self.top], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                             universal_newlines=True)
        return run.returncode, run.stdout

    def refuses(self, *places):
        code, output = self.run_tool("tools/check/bindings")
        self.assertEqual(code, 1, output)
        for place in places:
            self.assertIn(place, output)

    def test_agreement_passes(self):
        code, output = self.run_tool("tools/check/bindings")
        self.assertEqual(code, 0, output)
        number = re.fullmatch(r"bindings: (\d+) of \1 functions in Fortran, Python\n", output).group(1)
        with open(os.path.join(TOP, SYM), encoding="utf-8") as stream:
            self.assertEqual(int(number), len(re.findall("toliman_[a-z]", stream.read())))

    def test_changed_header(self):
        for name, before, after in (
                (PERIOD, "double t, double y,\n", "float t, double y,\n"),
                (BASE, "int32_t processors;", "int64_t processors;"),
                (BASE, "#define TOLIMAN_E_STATE 13", "#define TOLIMAN_E_STATE 14"),
                (BASE, "bug in the library", "bug")):
            with self.subTest(after):
                self.setUp()
                self.change(name, before, after)
                if "float" in after:
                    self.refuses("include/toliman/period.h:", "expected a type of <stdint.h>")
                else:
                    self.refuses(FORTRAN + ":", PYTHON + ":", "differs from the output of tools/gen/generate")

    def test_changed_network(self):
        self.change(LAYOUT, '{"conv2.weight", {16, 8, 3, 3}}', '{"conv2.weight", {16, 8, 5, 5}}')
        self.refuses(NETWORK + ":", "differs from the output of tools/gen/generate")
        self.change(LAYOUT, '{"conv2.bias", {16}}', '{"conv2_bias", {16}}')
        self.refuses(LAYOUT + ": 19 tensors and 4 stages were found: must be 20 and 4")

    def test_changed_binding(self):
        self.change(FORTRAN, "toliman_version_number() bind(C)", "toliman_version_numbers() bind(C)")
        self.change(PYTHON, '    "toliman_version_number": (', '    "toliman_version_numbers": (')
        self.refuses(FORTRAN + ": toliman_version_number is missing", PYTHON + ": toliman_version_number is missing",
                     FORTRAN + ":", "differs from the output of tools/gen")

    def test_function_without_binding(self):
        self.change(SYM, "    toliman_version;", "    toliman_version;\n    toliman_other;")
        self.refuses(FORTRAN + ": toliman_other is missing", PYTHON + ": toliman_other is missing")

    def test_new_function_is_generated_for_all(self):
        self.change(LINEAR, "/* Writes the predicted standard",
                    "/* New. */\nTOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_query_new(\n"
                    "    const toliman_linear *linear, double *out) TOLIMAN_NOEXCEPT;\n\n/* Writes the predicted standard")
        self.change(SYM, "    toliman_version;", "    toliman_version;\n    toliman_linear_query_new;")
        self.refuses("toliman_linear_query_new is missing")
        self.assertEqual(self.run_tool("tools/gen/generate"), (0, ""))
        code, output = self.run_tool("tools/check/bindings")
        self.assertEqual(code, 0, output)
        with open(os.path.join(self.top, FORTRAN), encoding="utf-8") as stream:
            self.assertIn("procedure :: query_new => linear_estimator_query_new", stream.read())

    def test_what_the_table_of_shapes_forgets(self):
        for before, after, complaint in (
                ("toliman_period_query_power: power[count]\n", "",
                 "toliman_period_query_power: no argument has the extent count"),
                ("t[n] y[n] sigma[n]?\n", "t[n] sigma[n]?\n",
                 "toliman_period_push_many: y needs extents"),
                ("toliman_linear_encode: counts[rows]", "toliman_linear_encode: counts[row]",
                 "toliman_linear_encode: row is neither an argument nor a property of toliman_linear"),
                ("toliman_components_push_many: count\n", "",
                 "toliman_components_push_many: no argument has the extent count"),
                ("toliman_track_merge: lost?\n", "",
                 "toliman_track_merge: the comment states that an argument may be NULL"),
                ("toliman_track_merge:", "toliman_track_merged:", "toliman_track_merged is not a function"),
                ("merge: lost?", "merge: lots?", "lots?: expected a pointer argument of toliman_track_merge"),
                ("merge: lost?", "merge: lost?\ntoliman_sim_get_info: sim[", "sim[: expected a pointer")):
            with self.subTest(complaint):
                self.setUp()
                self.change("tools/gen/shapes", before, after)
                self.refuses(complaint)

    def test_handle_without_owner(self):
        self.change("include/toliman/toliman.hpp", "handle<toliman_cae,", "handle<toliman_cats,")
        self.refuses("toliman.hpp: no owner of toliman_cae")

    def test_function_without_comment(self):
        with open(os.path.join(self.top, TRACK), encoding="utf-8") as stream:
            comment = re.findall(r"(?s)/\*(?:(?!/\*).)*?\*/\n(?=TOLIMAN_API[^;]*?\btoliman_track_save\()", stream.read())[-1]
        self.change(TRACK, comment, "\n")
        self.refuses("include/toliman/track.h:", "expected a comment above toliman_track_save")


if __name__ == "__main__":
    unittest.main()
