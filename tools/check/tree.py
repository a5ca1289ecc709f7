"""What the checks share: the files of the tree and the way to complain."""
import os
import re
import shutil
import subprocess
import sys

CODE = (".c", ".cpp", ".h", ".hpp")


def root(arguments):
    """The tree to check: the argument, or the one this script stands in."""
    if arguments:
        return os.path.abspath(arguments[0])
    return os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def files(top):
    """Paths relative to top: those git knows or would add, or, outside a repository, all."""
    if os.path.exists(os.path.join(top, ".git")):
        listed = subprocess.run(["git", "-C", top, "ls-files", "-co", "--exclude-standard"], check=True,
                                stdout=subprocess.PIPE, universal_newlines=True).stdout.split("\n")
        return sorted(name for name in listed if name and os.path.isfile(os.path.join(top, name)))
    found = []
    for folder, _, names in os.walk(top):
        found += [os.path.relpath(os.path.join(folder, name), top) for name in names]
    return sorted(found)


def lines(top, name):
    """The lines of a text file, None for a binary one."""
    with open(os.path.join(top, name), "rb") as stream:
        data = stream.read()
    return None if b"\0" in data else data.decode("utf-8", "replace").splitlines()


def without_comments(text):
    """C or C++ text with its comments blanked, line breaks kept."""
    def blank(match):
        return re.sub(r"[^\n]", " ", match.group())
    return re.sub(r"//[^\n]*|/\*.*?\*/", blank, text, flags=re.S)


def need(check, *programs):
    """Complains of programs that are not installed, without which the check would say nothing."""
    missing = [program for program in programs if shutil.which(program) is None]
    if missing:
        finish(check, ["%s is not installed: run tools/deps/install check" % program for program in missing])


def finish(check, complaints):
    """Prints the complaints and ends with 1 if there were any."""
    for complaint in complaints:
        print(complaint)
    if complaints:
        print("%s: %d complaint%s" % (check, len(complaints), "s" if len(complaints) > 1 else ""))
    sys.exit(1 if complaints else 0)
