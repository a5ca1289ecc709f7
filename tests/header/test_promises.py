"""Tests the check of promises with small trees: sentences, tests without a promise, promises without a test, the index."""
import unittest

from test_checks import Tree

HEADER = """/* Adds a sample. Any order of
 * pushes gives the same bits (promise: any-order). More follows. */
"""
TEST = "/* promise: any-order */\nstatic void orders(void **state) {\n"


class Promises(Tree):
    def setUp(self):
        super().setUp()
        self.write("include/toliman/period.h", HEADER)
        self.write("tests/unit/test_period.c", TEST)

    def test_every_promise_has_a_test(self):
        self.assertEqual(self.run_check("promises"), (0, ""))
        self.refuses("promises", "include/toliman/sim.h", "/* A (promise: b). */\n", "sim.h:1: promise b has no test")
        self.refuses("promises", "tests/cli/test_x.py", "# promise: c\n", "test_x.py:1: promise c is not stated anywhere")
        self.refuses("promises", "README.md", "Again (promise: any-order).\n", "any-order is stated at")

    def test_a_promise_is_found_by_its_words(self):
        code, output = self.run_check("promises", "same", "bits")
        self.assertEqual(code, 0)
        self.assertEqual(output.splitlines()[0], "any-order: Any order of pushes gives the same bits")
        self.assertIn("orders: ctest --test-dir build -R '^unit/test_period$'", output)
        self.assertEqual(self.run_check("promises", "nothing")[0], 1)

    def test_sentences_are_read_without_their_marks(self):
        for text, sentence in (("/* One. Two (promise: x). */", "Two"), ("/* A (promise: y). B (promise: x), always. */", "B"),
                               (" * Order    The sums are\n *          exact (promise: x).", "The sums are exact"),
                               (" *   n  number\n * It is finite (promise: x).", "It is finite"),
                               (" *   - E_A if a;\n *   - E_B if b (promise: x);", "E_B if b"), ("| 1 | rows (promise: x) | c |", "rows"),
                               ("    int n; /* number,\n            0 = all (promise: x) */", "number, 0 = all"),
                               ("**Lock.** One holds it (promise: x).", "One holds it")):
            self.write("include/toliman/period.h", HEADER + text.replace("promise: x", "promise: any") + "\n")
            self.assertIn("any: %s\n" % sentence, self.run_check("promises", "any")[1])

    def test_studies_are_commands(self):
        self.write("Makefile", "planets: everything ## compare\n\t@python3 tools/studies/planets.py\n")
        self.write("tools/studies/planets.py", '"""Posteriors. promises: any-order"""\n')
        self.assertIn("make planets", self.run_check("promises", "any-order")[1])

    def test_the_index_is_that_of_the_tree(self):
        marks = "<!-- index of promises: tools/check/promises --write -->\n<!-- end of the index -->\n"
        self.write("tools/docs/reliability.md", "| tests pass (promise: tests-pass) | 1 |\n" + marks)
        self.write("tests/unit/test_all.c", "/* promises: tests-pass, any-order */\nstatic void all(void **state) {\n")
        self.assertIn("the index is not that of the tree", self.run_check("promises")[1])
        self.assertEqual(self.run_check("promises", "--write"), (0, ""))
        self.assertEqual(self.run_check("promises"), (0, ""))
        with open(self.top + "/tools/docs/reliability.md") as stream:
            self.assertIn("| tests-pass | reliability.md | unit/test_all all |", stream.read())


if __name__ == "__main__":
    unittest.main()
