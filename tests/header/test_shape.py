"""Tests tools/check/shape with headers of another shape: each must be named with its line."""
import os
import re
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from copied_tree import TOP, CopiedTree

# One change of a header each, and the complaint.
CHANGES = [
    ("fit.h", "toliman_fit_get_info(", "toliman_fit_tell_info(", "toliman_fit_tell_info has no verb of the list"),
    ("fit.h", "toliman_fit_get_info(", "toliman_fitting_get_info(", "does not begin with the name of an object"),
    ("fit.h", "toliman_fit_get_info(", "toliman_mask_get_info_2(", "is named after mask, but its first argument is a fit"),
    ("period.h", "toliman_period_push_many(", "toliman_period_pushs(", "must be named toliman_period_push_many"),
    ("mask.h", "toliman_mask_create(", "toliman_mask_plan(", "has no toliman_mask_create"),
    ("mask.h", "toliman_mask_destroy(", "toliman_mask_finish(", "has no toliman_mask_destroy"),
    ("measure.h", "int64_t index,", "int32_t index,", "has the index index of type int32_t: must be int64_t"),
    ("bank.h", "int64_t networks;\n    int64_t trained", "uint64_t networks;\n    int64_t trained",
     "has an index below toliman_bank_info.networks, which must be int64_t"),
    ("ingest.h", "size_t *count,\n", "size_t *points,\n", "must have the arguments (..., array, capacity, count)"),
    ("cae.h", "size_t *needed)", "size_t *size)", "must have the arguments (..., array, capacity, needed)"),
    ("mask.h", "size_t count,\n", "size_t *count,\n", "writes count, which must follow array and capacity"),
    ("cae.h", "int32_t trained; ", "uint32_t trained;", "has the truth value trained of type uint32_t: must be int32_t"),
    ("fit.h", "uint32_t flags;\n", "int32_t flags;\n",
     "has flags of type int32_t: must be uint32_t"),
    ("linear.h", "double *values_px,", "uint32_t threads, double *values_px,",
     "has threads: must be a member of options"),
    ("mask.h", "list of the parameters", "list, separated by commas, of the parameters", "describes how names are separated"),
    ("base.h", 'Returns "?" for', "Returns NULL for", 'the name of an unknown value is "?"'),
]


class Shape(CopiedTree):
    PARTS = ("CMakeLists.txt", "include")

    def test_good(self):
        self.assertEqual(self.run_tool("tools/check/shape"), (0, ""))

    def test_bad(self):
        """All changes at once, and another round for those of a place that has one already."""
        changes = CHANGES
        while changes:
            self.setUp()
            first = {change[:2]: change for change in reversed(changes)}
            for header, before, after, _ in first.values():
                self.change(f"include/toliman/{header}", before, after)
            code, output = self.run_tool("tools/check/shape")
            self.assertEqual(code, 1, output)
            for header, _, _, complaint in first.values():
                with self.subTest(complaint):
                    self.assertRegex(output, rf"(?m)^include/toliman/{header}:\d+: .*{re.escape(complaint)}")
            changes = [change for change in changes if change not in first.values()]


if __name__ == "__main__":
    unittest.main()
