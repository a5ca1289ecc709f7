"""Shared by the checks: the files of the tree, and reporting. As a program it lists the files. Usage: tree.py [tree]"""
import errno
import fnmatch
import os
import re
import shutil
import subprocess
import sys

CODE = (".c", ".cpp", ".h", ".hpp")
# Folders that contain one of these are excluded: build trees and other repositories.
APART = ("CMakeCache.txt", "build.ninja", ".git")


def root(arguments):
    """The tree to check: the argument, or the one that contains this script."""
    if arguments:
        if not os.path.isdir(arguments[0]):
            raise NotADirectoryError(errno.ENOTDIR, "not a folder", arguments[0])
        return os.path.abspath(arguments[0])
    return os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def known_to_git(top):
    """The files that git tracks or would add; None outside a repository and if git cannot read it."""
    if not os.path.exists(os.path.join(top, ".git")):
        return None
    # Any owner is accepted: files are listed only, nothing of the tree is executed.
    command = ["git", "-c", "safe.directory=*", "-c", "core.fsmonitor=false", "-C", top]
    try:
        run = subprocess.run([*command, "ls-files", "-coz", "--exclude-standard"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    except OSError:
        return None
    return {os.fsdecode(name) for name in run.stdout.split(b"\0")} if run.returncode == 0 else None


def ignore_rules(top):
    """The lines of .gitignore."""
    path = os.path.join(top, ".gitignore")
    return [rule for rule in lines(top, ".gitignore") if rule and rule[0] != "#"] if os.path.exists(path) else []


def ignored(name, is_folder, rules):
    """Whether a rule of .gitignore excludes the path. Negations and ** are not supported."""
    for rule in rules:
        path = name if "/" in rule.rstrip("/") else os.path.basename(name)
        if fnmatch.fnmatchcase(path, rule.strip("/")) and (is_folder or not rule.endswith("/")):
            return True
    return False


def files(top):
    """Paths relative to top of the project's files, without build trees and what git ignores."""
    rules, found = ignore_rules(top), set()
    for folder, folders, names in os.walk(top):
        inside = os.path.relpath(folder, top)
        path = {name: os.path.normpath(os.path.join(inside, name)) for name in folders + names}
        folders[:] = [name for name in folders if name != ".git" and not ignored(path[name], True, rules)
                      and not any(os.path.exists(os.path.join(folder, name, mark)) for mark in APART)]
        found.update(path[name] for name in names if name != ".git" and not ignored(path[name], False, rules)
                     and os.path.isfile(os.path.join(folder, name)))
    known = known_to_git(top)
    return sorted(found if known is None else found & known)


def lines(top, name):
    """The lines of a text file, None for a binary one."""
    with open(os.path.join(top, name), "rb") as stream:
        data = stream.read()
    return None if b"\0" in data else data.decode("utf-8", "replace").splitlines()


def without_comments(text):
    """C or C++ text with comments replaced by blanks; line breaks are kept."""
    def blank(match):
        return re.sub(r"[^\n]", " ", match.group())
    return re.sub(r"//[^\n]*|/\*.*?\*/", blank, text, flags=re.S)


def need(check, *programs):
    """Complains about programs that are not installed, without which the check cannot work."""
    missing = [program for program in programs if shutil.which(program) is None]
    if missing:
        finish(check, ["%s is not installed: run tools/deps/install check" % program for program in missing])


def finish(check, complaints):
    """Prints the complaints and exits with 1 if there are any."""
    sys.stdout.reconfigure(errors="backslashreplace")  # file names may be any bytes
    for complaint in complaints:
        print(complaint)
    if complaints:
        print("%s: %d complaint%s" % (check, len(complaints), "s" if len(complaints) > 1 else ""))
    sys.exit(1 if complaints else 0)


def run(main):
    """Runs a check. A file that it cannot read, or a program that it cannot run, is a complaint."""
    try:
        main()
    except OSError as error:
        why = "%s: %s" % (error.filename, error.strerror)
    except subprocess.CalledProcessError as error:
        why = str(error)
    else:
        return
    finish(os.path.basename(sys.argv[0]), [why])


if __name__ == "__main__":
    run(lambda: print("\n".join(files(root(sys.argv[1:])))))
