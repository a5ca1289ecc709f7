"""Tests tools/check/abi with headers that break existing programs, and with compatible additions."""
import os
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from copied_tree import TOP, CopiedTree
sys.path.append(os.path.join(TOP, "tools/check"))
import interface

BASE, SIM, PERIOD = "include/toliman/base.h", "include/toliman/sim.h", "include/toliman/period.h"
SYM, RECORD, OLDEST = "lib/api/toliman.sym", "tests/abi/interface", "lib/api/oldest.hpp"
LAST = "    const char *fftw;\n"


PROCESSORS = "    int32_t processors;\n"
CODE = "#define TOLIMAN_E_STATE 13 "
MACHINE = "TOLIMAN_API TOLIMAN_MUST_CHECK toliman_status toliman_get_machine(toliman_machine *out) TOLIMAN_NOEXCEPT;\n"
CLOCK = "    size_t count;\n} toliman_track_clock;"
# Changes of the headers, each a file and its text before and after, and what the check says of them.
BREAKS = (
    ((BASE, LAST, "    double new_one;\n" + LAST), "new member toliman_machine.new_one at 48: double, within the 56 bytes"),
    ((BASE, "    int32_t processors;", "    uint32_t processors;"), "toliman_machine.processors at 4: int32_t -> at 4: uint32_t"),
    ((BASE, "    int32_t processors;", "    int32_t cores;"), "member toliman_machine.processors is gone"),
    (("include/toliman/track_records.h", "char session[72]", "char session[80]"), "toliman_track_stream.session at "),
    (("include/toliman/track_options.h", CLOCK, CLOCK.replace("}", "    int64_t one_more;\n}")), "it has no struct_size"),
    ((SIM, "#define TOLIMAN_SIM_UNIT_DN 303", "#define TOLIMAN_SIM_UNIT_DN 304"),
     "TOLIMAN_SIM_UNIT_DN: = 303 -> = 304: programs"),
    ((SIM, "#define TOLIMAN_SIM_UNIT_ELECTRON 302\n", ""), "constant TOLIMAN_SIM_UNIT_ELECTRON is gone"),
    ((BASE, CODE, "#define TOLIMAN_E_NEW 5\n" + CODE), "new constant TOLIMAN_E_NEW = 5, but codes are appended"),
    ((BASE, CODE, "#define TOLIMAN_E_NEW 15\n" + CODE), (BASE, CODE, "#define TOLIMAN_E_STATES 13 "),
     "constant TOLIMAN_E_STATE is gone: programs that name it do not compile"),
    ((BASE, MACHINE, MACHINE.replace("*out", "**out")),
     "toliman_get_machine: (toliman_machine *out) -> toliman_status -> (toliman_machine **out) -> toliman_status"),
    ((BASE, MACHINE, ""), "function toliman_get_machine is gone: programs that call it do not start"),
    ((BASE, "toliman_abi_version(void)", "toliman_abi_version(int32_t of)"), "toliman_abi_version: (void)"),
    ((BASE, "(*toliman_progress_fn)(const char *stage, double", "(*toliman_progress_fn)(const char *stage, int64_t"),
     "callback toliman_progress_fn: (const char *stage, double fraction"),
    ((BASE, "typedef int32_t toliman_status;", "typedef int64_t toliman_status;"), "type toliman_status: = int32_t -> = int64_t"),
    ((SIM, "    int32_t reserved;\n", "    uint32_t new_one;\n"), "member toliman_sim_options.reserved is gone"),
)


class Tree(CopiedTree):
    PARTS = ("CMakeLists.txt", "include", "lib", "tools/gen", "tests/abi")


class Headers(Tree):
    """The check of the headers' text alone."""

    def compare(self, *changes):
        for change in changes:
            self.change(*change)
        return interface.compare(self.read(RECORD), interface.describe(self.top), self.top)

    def refuses(self, *changes_and_why):
        """The check's output for these changes must name the line of the record."""
        *changes, why = changes_and_why
        breaks, _ = self.compare(*changes)
        found = [(line, text) for line, text in breaks if why in text]
        self.assertTrue(found, breaks)
        return self.read(RECORD).splitlines()[found[0][0] - 1]

    def accepts(self, *changes_and_what):
        *changes, what = changes_and_what
        breaks, additions = self.compare(*changes)
        self.assertEqual(breaks, [])
        self.assertIn(what, "\n".join(additions))

    def test_the_same(self):
        self.assertEqual(self.compare(), ([], []))

    def test_what_breaks_programs(self):
        for *changes, why in BREAKS:
            with self.subTest(why):
                texts = [(name, self.change(name, before, after)) for name, before, after in changes]
                self.refuses(why)
                for name, text in reversed(texts):
                    self.write(name, text)

    def test_line_of_the_record(self):
        line = self.refuses((BASE, PROCESSORS, "    int32_t new_one;\n" + PROCESSORS),
                            "member toliman_machine.processors at 4: int32_t -> at 8: int32_t (and 7 more)")
        self.assertEqual(line, "    member toliman_machine.processors at 4: int32_t")

    def test_member_in_padding(self):
        """If the size of a struct is unchanged, the library cannot know whether its caller knows a new member."""
        self.change(BASE, LAST, LAST + "    int32_t odd;\n")
        self.write(RECORD, interface.describe(self.top))
        self.refuses((BASE, "    int32_t odd;\n", "    int32_t odd, even;\n"), "even at 60: int32_t, within the 64 bytes")

    def test_growth(self):
        """Also for a result struct: the library must still fill it for callers who know fewer members."""
        self.refuses((BASE, LAST, LAST + "    double new_one;\n"),
                     "lib/api refuses the 56 bytes of programs built before: give it kOldest<toliman_machine> = 56")
        line = "template <> inline constexpr size_t kOldest<toliman_machine> = %s;\n"
        for refused in (line % 64, "// " + line % 56):
            self.write(OLDEST, refused)
            self.refuses("lib/api refuses the 56 bytes")
        for number, size in (("40", 40), ("offsetof(toliman_machine, new_one)", 56), ("56", 56)):
            self.write(OLDEST, line % number)
            _, additions = self.compare()
            self.assertIn(f"struct toliman_machine of 56 bytes, taken from 56 -> of 64 bytes, taken from {size}", additions)
            self.assertIn("member toliman_machine.new_one at 56: double", additions)
        self.write(RECORD, interface.describe(self.top))
        self.write(OLDEST, line % 64)
        self.refuses("lib/api refuses the 56 bytes of programs built before")

    def test_additions(self):
        self.accepts((BASE, "#define TOLIMAN_E_STATE 13 ", "#define TOLIMAN_E_NEW 15\n#define TOLIMAN_E_STATE 13 "),
                     "constant TOLIMAN_E_NEW = 15")
        self.accepts((BASE, "TOLIMAN_API int32_t toliman_abi_version",
                      "TOLIMAN_API int32_t toliman_new(void) TOLIMAN_NOEXCEPT;\nTOLIMAN_API int32_t toliman_abi_version"),
                     "function toliman_new (void) -> int32_t")
        self.accepts((SIM, "    int32_t reserved;\n", "    int32_t new_one;\n"), "member toliman_sim_options.new_one at 44")


class Program(Tree):
    """tools/check/abi."""

    def check(self, *arguments):
        return self.run_tool("tools/check/abi", *arguments)

    def refuses(self, *why):
        """Also to update the record."""
        recorded = self.read(RECORD)
        for arguments in ((), ("--record",)):
            code, output = self.check(*arguments)
            self.assertEqual(code, 1, output)
            for text in (*why, "raise TOLIMAN_ABI_VERSION"):
                self.assertIn(text, output)
        self.assertEqual(self.read(RECORD), recorded)

    def test_nothing_changed(self):
        self.assertEqual(self.check(), (0, ""))

    def test_first_record(self):
        os.remove(os.path.join(self.top, RECORD))
        self.assertEqual(self.check("--record"), (0, "recorded: all of it\n"))
        self.assertEqual(self.check(), (0, ""))

    def test_break(self):
        """Recorded once the versions are raised."""
        self.change(BASE, PROCESSORS, "    double new_one;\n" + PROCESSORS)
        self.refuses(RECORD + ":", "member toliman_machine.processors at 4: int32_t -> at 16: int32_t")
        self.change("CMakeLists.txt", "set(TOLIMAN_ABI_VERSION 2)", "set(TOLIMAN_ABI_VERSION 3)")
        self.refuses("processors at 4")
        self.change("CMakeLists.txt", "project(toliman VERSION 0.3.0", "project(toliman VERSION 0.4.0")
        code, output = self.check("--record")
        self.assertEqual(code, 0, output)
        self.assertIn("recorded: version abi 2 of 0.3 -> 3 of 0.4", output)
        self.assertEqual(self.check(), (0, ""))

    def test_addition(self):
        self.change(BASE, LAST, LAST + "    double new_one;\n")
        self.change(OLDEST, "\n} // namespace", "template <> inline constexpr size_t kOldest<toliman_machine> = 56;\n} // namespace")
        code, output = self.check()
        self.assertEqual(code, 1)
        self.assertIn("not recorded, run make abi: struct toliman_machine of 56 bytes, taken from 56 -> of 64 bytes, taken from 56", output)
        code, output = self.check("--record")
        self.assertEqual(code, 0, output)
        self.assertIn("recorded: struct toliman_machine of 56 bytes, taken from 56 -> of 64 bytes", output)
        self.assertEqual(self.check(), (0, ""))


if __name__ == "__main__":
    unittest.main()
