"""Tests tools/check/units: a file of a folder that changes the meaning of another one is found, whatever kind of name it has."""
import importlib.machinery
import importlib.util
import os
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
PATH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tools/check/units")
LOADER = importlib.machinery.SourceFileLoader("units", PATH)
units = importlib.util.module_from_spec(importlib.util.spec_from_loader("units", LOADER))
LOADER.exec_module(units)

HEAD = "namespace lib { bool holds(int); constexpr double kLimit = 2.5; int sum(double); struct Pair { int a = 1, b = 2; };\n"
USER = HEAD + "namespace part { bool user(long x) { return %s; } } }\n"
# (what another file of the folder has, what the user calls, whether the unit changes it)
CASES = [
    ("bool holds(int);", "holds(static_cast<int>(x))", True),  # hides a function
    ("bool holds(long);", "holds(static_cast<int>(x))", True),
    ("constexpr double kLimit = 7.5;", "static_cast<double>(x) > kLimit", True),  # hides a constant
    ("struct Pair { int a = 100, b = 200; };", "Pair().b > x", True),  # hides a type
    ("namespace { int sum(long x) { return int(x); } int (*const used)(long) = sum; }", "sum(x) > 0", True),  # a better overload
    ("bool other(int);", "holds(static_cast<int>(x))", False),
    ("namespace { bool holds(int, int) { return true; } bool (*const used)(int, int) = holds; }", "lib::holds(1)", False),
]


class Units(unittest.TestCase):
    def test_each_kind_of_name(self):
        for other, call, differs in CASES:
            with self.subTest(other), tempfile.TemporaryDirectory() as folder:
                texts = {"a.cpp": HEAD + "namespace part { " + other + " } }\n", "b.cpp": USER % call}
                texts["unit.cpp"] = texts["a.cpp"] + texts["b.cpp"].replace(HEAD, "namespace lib {\n")
                compiled = {}
                for name, text in texts.items():
                    with open(os.path.join(folder, name), "w", encoding="utf-8") as stream:
                        stream.write(text)
                    compiled[name] = units.assembly((folder, f"g++ -std=c++17 -c {name} -o {name}.o", name))
                alone = units.gathered([compiled["a.cpp"], compiled["b.cpp"]])
                found = units.changed(alone, units.gathered([compiled["unit.cpp"]]))
                self.assertEqual([name for name in found if "user" in name], ["_ZN3lib4part4userEl"] if differs else [])


if __name__ == "__main__":
    unittest.main()
