"""A copy of parts of the source tree, or a tree of files made for a test, on which programs of tools run."""
import os
import shutil
import subprocess
import tempfile
import unittest

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


class CopiedTree(unittest.TestCase):
    PARTS = ()  # files and folders that are copied

    def setUp(self):
        self.top = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.top)
        for name in self.PARTS:
            place = os.path.join(self.top, name)
            os.makedirs(os.path.dirname(place), exist_ok=True)
            (shutil.copytree if os.path.isdir(os.path.join(TOP, name)) else shutil.copy)(os.path.join(TOP, name), place)

    def read(self, name):
        with open(os.path.join(self.top, name), encoding="utf-8") as stream:
            return stream.read()

    def write(self, name, text):
        """Returns the path of the file."""
        path = os.path.join(self.top, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(text)
        return path

    def change(self, name, before, after):
        """Replaces the first occurrence; returns the text before."""
        text = self.read(name)
        self.assertIn(before, text)
        self.write(name, text.replace(before, after, 1))
        return text

    def run_tool(self, tool, *arguments, **environment):
        """Exit code and output of a program of the project for this tree."""
        run = subprocess.run([os.path.join(TOP, tool), *arguments, self.top], stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, universal_newlines=True, env={**os.environ, **environment})
        return run.returncode, run.stdout
