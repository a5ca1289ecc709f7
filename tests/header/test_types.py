"""Tests enumerations and structs of the headers: distinct values per enumeration, one type, and an initialiser each."""
import os
import re
import subprocess
import sys
import tempfile
import unittest

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(TOP, "tools", "gen"))
import model  # noqa: E402

HEADERS = model.read(TOP)
STRUCTS = [struct.name for struct in HEADERS.all(model.Struct) if struct.sized]
# Last words in the names of members and arguments that hold an enumeration.
CHOICES = {"calibration", "cause", "engine", "encoding", "event", "format", "goodness", "input", "kind", "layout", "level", "method", "mode", "normalisation", "pixel", "reason",
           "scale", "scope", "stamp", "sync", "unit", "verdict"}


def header_text():
    folder = os.path.join(TOP, "include", "toliman")
    texts = []
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), encoding="utf-8") as stream:
            texts.append(stream.read())
    return "".join(texts)


class Enumerations(unittest.TestCase):
    # promise: wrong-enumerations-are-refused
    def test_no_two_constants_share_a_value(self):
        found = re.findall(r"^#define (TOLIMAN_\w+)(?: |\s*\\\s*\n\s*)(\d+)(u?)\b", header_text(), re.M)
        constants = [(name, value) for name, value, is_flag in found if not is_flag]
        self.assertGreater(len(constants), 60)
        self.assertIn(("TOLIMAN_PERIOD_FAP_BALUEV", "111"), constants)  # whose value is on a line of its own
        of_value = {}
        for name, value in constants:
            self.assertNotIn(value, of_value, f"{name} has the value of {of_value.get(value)}")
            of_value[value] = name

    def test_members_and_arguments_are_int32(self):
        seen = set()
        for item in HEADERS.items:
            for named in getattr(item, "fields", getattr(item, "arguments", [])):
                base, last_word = HEADERS.plain(named.type.base), named.name.split("_")[-1]
                if last_word in CHOICES and not named.type.pointers and base != "double":
                    self.assertEqual(base, "int32_t", f"{item.name}: {named.name}")
                    seen.add(last_word)
        self.assertEqual(seen, CHOICES)


class WithoutStatus(unittest.TestCase):
    def test_all_are_tested_with_wrong_objects(self):
        with open(os.path.join(TOP, "tests", "unit", "test_misuse.c"), encoding="utf-8") as stream:
            text = stream.read()
        handles = {handle.name for handle in HEADERS.all(model.Handle)}
        named = [function.name for function in HEADERS.all(model.Function)
                 if not function.status and function.arguments and function.arguments[0].type.base in handles]
        self.assertGreater(len(named), 15)
        self.assertEqual([name for name in named if not re.search(rf"\b{name}\b", text)], [])


class Initialisers(unittest.TestCase):
    """Each struct has no gap between members, whose bytes would be those of the stack. Each with a struct_size has
    TOLIMAN_..._INIT in C and sized<...>() in C++, which compile without a
    warning."""

    def run_program(self, compiler, name, lines):
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, "toliman"))
            with open(os.path.join(folder, "toliman", "version.h"), "w", encoding="utf-8") as stream:
                stream.write(model.version_header(TOP))
            with open(os.path.join(folder, name), "w", encoding="utf-8") as stream:
                stream.write("\n".join(lines))
            program = os.path.join(folder, "program")
            command = [*compiler, "-pedantic", "-Wall", "-Wextra", "-Werror", "-I" + folder,
                       "-I" + os.path.join(TOP, "include"), name, "-o", program]
            made = subprocess.run(command, cwd=folder, capture_output=True, text=True)
            self.assertEqual(made.returncode, 0, made.stderr)
            self.assertEqual(subprocess.run([program]).returncode, 0)

    def test_c(self):
        for standard in ("c99", "c11"):
            self.run_program(["gcc", "-Wpadded", "-std=" + standard], "program.c", [
                "#include <toliman/toliman.h>", "int main(void) {", "int good = 1;",
                *(f"{{ {name} made = {name.upper()}_INIT; good &= made.struct_size == sizeof made; }}" for name in STRUCTS),
                "return !good;", "}", ""])

    def test_cpp(self):
        self.run_program(["g++", "-std=c++11"], "program.cpp", [
            "#include <toliman/toliman.hpp>", "int main() {", "bool good = true;",
            *(f"good &= toliman::sized<{name}>().struct_size == sizeof({name});" for name in STRUCTS),
            "return good ? 0 : 1;", "}", ""])


if __name__ == "__main__":
    unittest.main()
