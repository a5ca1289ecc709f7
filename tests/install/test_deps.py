"""Tests tools/deps/install on simulated systems: a PATH with stand-ins that record their calls."""
import os
import shutil
import subprocess
import tempfile
import unittest

INSTALL = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tools/deps/install")


def packages(*uses):
    """Packages listed for these uses."""
    with open(os.path.join(os.path.dirname(INSTALL), "packages")) as stream:
        entries = [line.split() for line in stream if not line.startswith("#")]
    return [package for use, package in entries if use in uses]


class Install(unittest.TestCase):
    def setUp(self):
        self.top = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.top)
        for tool in ("sh", "env", "sed", "tr", "dirname", "cat"):
            os.symlink(shutil.which(tool), os.path.join(self.top, tool))
        self.stand_in("id", "echo 0")
        self.apt_get("main_Packages")

    def apt_get(self, lists):
        """apt-get with these package lists."""
        self.stand_in("apt-get", 'case $1 in indextargets) echo "%s" ;; *) echo "$DEBIAN_FRONTEND apt-get $*" >>"%s/calls" ;; esac'
                      % (lists, self.top))

    def stand_in(self, name, command):
        path = os.path.join(self.top, name)
        with open(path, "w") as stream:
            stream.write("#!/bin/sh\n%s\n" % command)
        os.chmod(path, 0o755)

    def installed(self, names, extra=""):
        with open(os.path.join(self.top, "status"), "w") as stream:
            stream.write("".join("installed %s \n" % name for name in names) + extra)
        self.stand_in("dpkg-query", 'cat "%s/status"' % self.top)

    def run_install(self, *arguments):
        """Exit code, output and the calls of apt-get."""
        run = subprocess.run([os.path.join(self.top, "sh"), INSTALL, *arguments], env={"PATH": self.top},
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                             universal_newlines=True)
        calls = os.path.join(self.top, "calls")
        if not os.path.exists(calls):
            return run.returncode, run.stdout, []
        with open(calls) as stream:
            return run.returncode, run.stdout, stream.read().splitlines()

    def test_silent_when_nothing_is_missing(self):
        self.installed(packages("build"))
        self.assertEqual(self.run_install("build"), (0, "", []))
        self.assertEqual(self.run_install(), (0, "", []))
        self.installed(packages("build", "check"))
        self.assertEqual(self.run_install("check"), (0, "", []))

    def test_root_installs_what_is_missing_and_no_more(self):
        self.installed(packages("build")[2:], "config-files %s \nnot-installed gfortran \n" % packages("build")[0])
        code, _, calls = self.run_install("build")
        self.assertEqual(code, 0)
        self.assertEqual(calls[0].strip(), "apt-get update")
        self.assertEqual(calls[1], "noninteractive apt-get install -y --no-install-recommends g++ gfortran")

    def test_check_adds_the_packages_of_the_tests(self):
        self.installed(packages("build"))
        _, _, calls = self.run_install("check")
        self.assertTrue(calls[1].endswith("--no-install-recommends " + " ".join(packages("check"))))

    def test_peers_are_for_benchmarks_only(self):
        self.installed(packages("build", "check"))
        _, _, calls = self.run_install("peers")
        self.assertTrue(calls[1].endswith("--no-install-recommends " + " ".join(packages("peers"))))

    def test_provided_and_foreign_names_count(self):
        names = [name for name in packages("build") if name not in ("pkg-config", "zlib1g-dev")]
        self.installed(names, "installed pkgconf other (= 1), pkg-config (= 2)\ninstalled zlib1g-dev:amd64 \n")
        self.assertEqual(self.run_install("build"), (0, "", []))

    def test_others_go_through_sudo(self):
        self.installed(packages("build")[1:])
        self.stand_in("id", "echo 1000")
        self.stand_in("sudo", 'echo "sudo $*" >>"%s/calls"' % self.top)
        code, _, calls = self.run_install()
        self.assertEqual(code, 0)
        self.assertIn("sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends g++", calls)

    def test_without_rights_the_command_is_printed(self):
        self.installed(packages("build")[1:])
        self.stand_in("id", "echo 1000")
        for sudo in (None, "exit 1"):
            if sudo:
                self.stand_in("sudo", sudo)
            code, output, calls = self.run_install()
            self.assertEqual((code, calls), (1, []))
            self.assertIn("apt-get update && apt-get install -y --no-install-recommends g++\n", output)

    def test_failure_of_apt_is_passed_on(self):
        self.installed(packages("build")[1:])
        self.stand_in("apt-get", "exit 100")
        self.assertEqual(self.run_install()[0], 100)

    def test_without_package_lists_the_network_is_named(self):
        self.installed(packages("build")[2:])
        self.apt_get("")
        code, output, calls = self.run_install()
        self.assertEqual((code, [call.strip() for call in calls]), (1, ["apt-get update"]))
        self.assertIn("There are no package lists: is the network up, and do apt's sources name a mirror of Debian 12?", output)
        self.assertIn("apt-get update && apt-get install -y --no-install-recommends %s\n" % " ".join(packages("build")[:2]),
                      output)

    def test_systems_without_dpkg_list_the_packages_and_continue(self):
        code, output, calls = self.run_install("check")
        self.assertEqual((code, calls), (0, []))
        for package in packages("build", "check"):
            self.assertIn(" " + package, output)

    def test_unknown_use(self):
        code, output, _ = self.run_install("all")
        self.assertEqual(code, 2)
        self.assertIn("usage: install", output)


if __name__ == "__main__":
    unittest.main()
