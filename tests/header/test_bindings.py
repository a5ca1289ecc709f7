"""Tests tools/gen and the check of bindings with headers, tables and lists of functions that disagree."""
import os
import re
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from copied_tree import TOP, CopiedTree
SYM, BASE, LINEAR, TRACK, PERIOD = ("lib/api/toliman.sym", "include/toliman/base.h", "include/toliman/linear.h",
                                    "include/toliman/track.h", "include/toliman/period.h")
FORTRAN, PYTHON = "fortran/toliman.f90", "python/toliman/_raw.py"
SIZES = "generated/api/struct_sizes.hpp"
LAYOUT, NETWORK = "lib/cae/layout.hpp", "python/toliman/report/_network.py"


class Bindings(CopiedTree):
    PARTS = ("CMakeLists.txt", SYM, "tools/gen/shapes", "tools/gen/toliman.f90.in", LAYOUT, "include", "tests/fault/scenarios")

    def generate(self):
        """Runs tools/gen/generate and returns the folder that it fills."""
        folder = os.path.join(self.top, "build")
        self.assertEqual(self.run_tool("tools/gen/generate", folder), (0, ""))
        return folder

    def made(self, name):
        """The text of a generated file."""
        self.generate()
        return self.read(os.path.join("build", name))

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
        for name, before, after, made, text in (
                (BASE, "int32_t processors;", "int64_t processors;", FORTRAN, "integer(c_int64_t) :: processors"),
                (BASE, "int32_t processors;", "int64_t processors;", PYTHON, '("processors", c_int64)'),
                (BASE, "#define TOLIMAN_E_STATE 13", "#define TOLIMAN_E_STATE 14", PYTHON, "TOLIMAN_E_STATE = 14"),
                (BASE, "bug in the library", "bug in it", FORTRAN, "bug in it")):
            with self.subTest(after, file=made):
                self.setUp()
                self.assertNotIn(text, self.made(made))
                self.change(name, before, after)
                self.assertIn(text, self.made(made))
        self.change(PERIOD, "double t, double y,\n", "float t, double y,\n")
        self.refuses("include/toliman/period.h:", "expected a type of <stdint.h>")

    def test_only_what_changes_is_written(self):
        """So that an edit of a comment compiles no source of the library again."""
        def times():
            return {name: os.stat(os.path.join(folder, name)).st_mtime_ns for name in (FORTRAN, PYTHON, SIZES, NETWORK)}
        folder = self.generate()
        for name in times():
            os.utime(os.path.join(folder, name), ns=(0, 0))
        self.change(BASE, "bug in the library", "bug in it")
        self.generate()
        self.assertEqual({name for name, time in times().items() if time}, {FORTRAN, PYTHON})

    def test_changed_network(self):
        self.change(LAYOUT, '{"conv2.weight", {16, 8, 3, 3}}', '{"conv2.weight", {16, 8, 5, 5}}')
        self.assertIn('"conv2.weight": (16, 8, 5, 5),', self.made(NETWORK))
        self.change(LAYOUT, '{"conv2.bias", {16}}', '{"conv2_bias", {16}}')
        self.refuses(LAYOUT + ": 19 tensors and 5 channels were found: must be 20 and 5")

    def test_function_without_binding(self):
        self.change(SYM, "    toliman_version;", "    toliman_version;\n    toliman_other;")
        self.refuses(FORTRAN + ": toliman_other is missing", PYTHON + ": toliman_other is missing")

    def test_new_function_is_generated_for_all(self):
        self.change(LINEAR, "/* Writes the predicted standard",
                    "/* New. */\nTOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_query_new(\n"
                    "    const toliman_linear *linear, double *out) TOLIMAN_NOEXCEPT;\n\n/* Writes the predicted standard")
        self.change(SYM, "    toliman_version;", "    toliman_version;\n    toliman_linear_query_new;")
        code, output = self.run_tool("tools/check/bindings")
        self.assertEqual(code, 0, output)
        self.assertIn("procedure :: query_new => linear_estimator_query_new", self.made(FORTRAN))

    def test_what_the_table_of_shapes_forgets(self):
        for before, after, complaint in (
                ("toliman_period_query_power: power[count]\n", "",
                 "toliman_period_query_power: no argument has the extent count"),
                ("t[n] y[n] sigma[n]?\n", "t[n] sigma[n]?\n",
                 "toliman_period_push_many: y needs extents"),
                ("toliman_sim_get_image: image[rows]", "toliman_sim_get_image: image[row]",
                 "toliman_sim_get_image: row is neither an argument nor a property of toliman_sim"),
                ("toliman_components_push: count\n", "",
                 "toliman_components_push: no argument has the extent count"),
                ("toliman_track_merge: lost?\n", "",
                 "toliman_track_merge: the comment states that an argument may be NULL"),
                ("toliman_track_merge:", "toliman_track_merged:", "toliman_track_merged is not a function"),
                ("merge: lost?", "merge: lots?", "lots?: expected a pointer argument of toliman_track_merge"),
                ("merge: lost?", "merge: lost?\ntoliman_sim_get_info: sim[", "sim[: expected a pointer")):
            with self.subTest(complaint):
                self.setUp()
                self.change("tools/gen/shapes", before, after)
                self.refuses(complaint)

    def test_scenarios_of_faults(self):
        """A new function has a scenario, or stops the build until its arguments have values."""
        scenarios = os.path.join(self.top, "scenarios.c")
        new = "/* New. */\nTOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_linear_query_new(\n" \
              "    const toliman_linear *linear, %s) TOLIMAN_NOEXCEPT;\n\n/* Writes the predicted standard"
        header = self.change(LINEAR, "/* Writes the predicted standard", new % "double *out")
        self.assertEqual(self.run_tool("tools/gen/scenarios", scenarios), (0, ""))
        self.assertIn("toliman_linear_query_new(a->object, (void *)(a->out +", self.read("scenarios.c"))
        self.write(LINEAR, header)
        self.change(LINEAR, "/* Writes the predicted standard", new % "double share, double *out")
        self.assertEqual(self.run_tool("tools/gen/scenarios", scenarios),
                         (1, "tests/fault/scenarios: toliman_linear_query_new: share has no value\n"))
        for line, complaint in (("toliman_linear_query_old: share=1", "is not a function or an object"),
                                ("toliman_linear_query_new: shares=1", "shares is not an argument or an extent"),
                                ("toliman_linear_query_new: share=1 quick", "quick is unknown")):
            text = self.change("tests/fault/scenarios", "# sky.h\n", line + "\n")
            self.assertIn(complaint, self.run_tool("tools/gen/scenarios", scenarios)[1])
            self.write("tests/fault/scenarios", text)

    def test_handle_without_owner(self):
        self.change("include/toliman/toliman.hpp", "handle<toliman_cae,", "handle<toliman_cats,")
        self.refuses("toliman.hpp: no owner of toliman_cae")

    def test_function_without_comment(self):
        comment = re.findall(r"(?s)/\*(?:(?!/\*).)*?\*/\n(?=TOLIMAN_API[^;]*?\btoliman_track_save\()", self.read(TRACK))[-1]
        self.change(TRACK, comment, "\n")
        self.refuses("include/toliman/track.h:", "expected a comment above toliman_track_save")


if __name__ == "__main__":
    unittest.main()
