"""A simulated system with only some Debian packages installed, and their dependencies: a folder of their programs as
the PATH, and Python without the modules of other packages."""
import os
import pathlib
import re
import subprocess

LIST = pathlib.Path(__file__).resolve().parents[2] / "tools" / "deps" / "packages"
BINARIES = ("/usr/bin", "/usr/sbin", "/bin", "/sbin")
SITE = """
import importlib.machinery, sys
class OnlyOf:
    def find_spec(name, path=None, target=None):
        found = importlib.machinery.PathFinder.find_spec(name, path, target)
        if found and found.origin and "/dist-packages/" in found.origin and found.origin not in FILES:
            raise ModuleNotFoundError(f"No module named {name!r} in the packages", name=name)
FILES = set(open(FILE).read().splitlines())
sys.meta_path.insert(0, OnlyOf)
"""


def installed_by_make():
    """Packages that `make` alone installs on a system with git and make."""
    entries = [line.split() for line in LIST.read_text().splitlines() if not line.startswith("#")]
    return [package for use, package in entries if use == "build"] + ["git", "make", "apt"]


class System:
    """Creates the system in a folder; raises OSError if dpkg does not know the packages, as on other systems."""

    def __init__(self, folder, names):
        self.folder = folder
        self.needs, self.providers, self.names, always = {}, {}, set(), []
        form = "${db:Status-Status}\t${Package}\t${Essential}\t${Priority}\t${Pre-Depends}, ${Depends}\t${Provides}\n"
        for line in subprocess.run(["dpkg-query", "-W", "-f", form], capture_output=True, text=True).stdout.splitlines():
            status, name, essential, priority, needs, provides = line.split("\t")
            if status == "installed":
                self.needs[name] = [re.findall(r"(?:^|\|)\s*([^\s|:(]+)", word) for word in needs.split(",")]
                for other in [name, *re.findall(r"(?:^|,)\s*([^\s,(]+)", provides)]:
                    self.providers.setdefault(other, []).append(name)
                if essential == "yes" or priority == "required":
                    always.append(name)
        self.add([*always, *names])

    def add(self, names):
        """Installs further packages."""
        left = list(names)
        while left:
            wanted = left.pop()
            if wanted not in self.providers:
                raise OSError(f"{wanted} is not installed")
            name = self.providers[wanted][0]
            if name not in self.names:
                self.names.add(name)
                present = ([one for one in choice if one in self.providers] for choice in self.needs[name])
                left += [choice[0] for choice in present if choice]
        listed = subprocess.run(["dpkg-query", "-L", *sorted(self.names)], capture_output=True, text=True, check=True).stdout
        files = listed.splitlines()
        self.programs = {os.path.realpath(path) for path in files if os.path.dirname(path) in BINARIES}
        (self.folder / "bin").mkdir(exist_ok=True)
        for entry in (entry for folder in BINARIES[:2] for entry in os.scandir(folder)):
            link = self.folder / "bin" / entry.name
            if os.path.realpath(entry.path) in self.programs and not link.is_symlink():
                link.symlink_to(entry.path)
        (self.folder / "files").write_text("\n".join(path for path in files if "/dist-packages/" in path))
        (self.folder / "sitecustomize.py").write_text(f"FILE = {str(self.folder / 'files')!r}\n" + SITE)

    def has(self, command):
        """Whether a command given by its full path exists; others are searched for on the PATH."""
        word = command.split()[0]
        return not word.startswith("/") or os.path.realpath(word) in self.programs

    def environment(self):
        return {"PATH": str(self.folder / "bin"), "PYTHONPATH": str(self.folder), "PYTHONDONTWRITEBYTECODE": "1"}
