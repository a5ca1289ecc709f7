"""Tests the check of exports with libraries that disagree with their headers or symbol list."""
import os
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from copied_tree import TOP, CopiedTree


class Exports(CopiedTree):
    def check(self, declared, listed, defined):
        """Exit code and output of the check for a library made of three lists of names."""
        header = "/* TOLIMAN_API int toliman_old(void); */\n"
        header += "".join("TOLIMAN_API TOLIMAN_MUST_CHECK int\n%s(int a);\n" % name for name in declared)
        self.write("include/toliman/a.h", header)
        script = "V_0 {\n  global:\n%s  local:\n    *;\n};\n" % "".join("    %s;\n" % name for name in listed)
        self.write("lib/api/toliman.sym", script)
        hidden = script.replace("    *;", "    hidden;")
        source = self.write("a.c", "".join("int %s(int a) { return a; }\n" % name for name in defined))
        library = os.path.join(self.top, "liba.so")
        subprocess.run(["cc", "-shared", "-fPIC", source, "-o", library,
                        "-Wl,--version-script=" + self.write("b.sym", hidden)], check=True)
        return self.run_tool("tools/check/exports", library)

    def refuses(self, place, *lists):
        code, output = self.check(*lists)
        self.assertEqual(code, 1, output)
        self.assertIn(place, output)

    def test_agreement_passes(self):
        both = ["toliman_a", "toliman_b"]
        self.assertEqual(self.check(both, both, both), (0, ""))

    def test_every_disagreement_is_found(self):
        one, two = ["toliman_a"], ["toliman_a", "toliman_b"]
        self.refuses("include/toliman/a.h:5: toliman_b is not listed", two, one, one)
        self.refuses("lib/api/toliman.sym:4: toliman_b is not declared", one, two, two)
        self.refuses("lib/api/toliman.sym:4: toliman_b is not exported", two, two, one)
        self.refuses("toliman_b is exported but not listed", two, one, two)
        self.refuses("other is exported without the prefix", ["other"], ["other"], ["other"])


class Isa(CopiedTree):
    def test_shared_inline_function_is_found(self):
        for text, code in (("static inline int f() { return 1; } int g() { return f(); }", 0),
                           ("inline int f() { return 1; } int (*g())() { return f; }", 1)):
            target = os.path.join(self.top, "a.o")
            subprocess.run(["c++", "-O2", "-c", self.write("a.cpp", text), "-o", target], check=True)
            run = subprocess.run([os.path.join(TOP, "tools/check/isa"), target], capture_output=True, text=True)
            self.assertEqual(run.returncode, code, run.stdout)


if __name__ == "__main__":
    unittest.main()
