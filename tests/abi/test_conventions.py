"""Tests the conventions for libraries in a host process: the library prints nothing, never exits, reads no environment
variables, and leaves locale, signals, rounding mode, BLAS threads and files unchanged, in every locale. The host is
conventions.c."""
import os
import re
import subprocess
import tempfile
import unittest

HOST, LIBRARY = os.environ["TOLIMAN_CONVENTIONS"], os.environ["TOLIMAN_LIBRARY"]
SOURCES = os.path.dirname(os.path.abspath(__file__))

# Functions that the library may not even import: those that exit or print, and those that change the process's state.
# Functions used by the C++ runtime (std::terminate, if a callback of the caller throws) are not in this list.
FORBIDDEN = """
    exit _exit _Exit quick_exit abort __assert_fail kill raise
    printf vprintf fprintf vfprintf dprintf puts putchar fputs fputc putc fwrite perror psignal stdout stderr
    __printf_chk __fprintf_chk __vprintf_chk __vfprintf_chk _ZSt4cout _ZSt4cerr _ZSt4clog
    setlocale uselocale newlocale signal sigaction sigprocmask pthread_sigmask sigaltstack
    getenv secure_getenv putenv setenv unsetenv clearenv environ __environ
    fesetround fesetenv feupdateenv feholdexcept feenableexcept fedisableexcept feraiseexcept
    openblas_set_num_threads goto_set_num_threads omp_set_num_threads fftw_plan_with_nthreads fftw_cleanup
    fftw_import_wisdom_from_filename cJSON_InitHooks
    system popen fork execve srand rand srandom umask chdir setrlimit mallopt
""".split()


def comma_locale(folder):
    """Creates a locale with a decimal comma from the tools of every Debian system; no installed language is
    needed."""
    def write(name, text):
        with open(os.path.join(folder, name), "w", encoding="ascii") as stream:
            stream.write(text)
    write("numbers", 'LC_NUMERIC\ndecimal_point ","\nthousands_sep "."\ngrouping 3;3\nEND LC_NUMERIC\n')
    write("ascii", "<code_set_name> ANSI_X3.4-1968\n<comment_char> %\n<escape_char> /\n"
                   "CHARMAP\n<U0000>..<U007F> /x00 NULL\nEND CHARMAP\n")
    subprocess.run(["localedef", "-c", "-f", "./ascii", "-i", "./numbers", "./comma"], cwd=folder,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # localedef warns about missing categories


class Conventions(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = kept.name
        comma_locale(self.folder)

    def host(self, how="", locale="C"):
        """Exit code, output, lines of the watch, messages."""
        names = [os.path.join(self.folder, name) for name in ("report", "messages")]
        for name in names:
            open(name, "w").close()
        run = subprocess.run([HOST, *names, *([how] if how else [])], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                             universal_newlines=True,
                             env={**os.environ, "LOCPATH": self.folder, "LC_ALL": locale, "TMPDIR": self.folder})
        texts = []
        for name in names:
            with open(name, encoding="utf-8") as stream:
                texts.append(stream.read().splitlines())
        return run.returncode, run.stdout, *texts

    def behaves(self, locale):
        code, output, watched, messages = self.host(locale=locale)
        self.assertEqual((code, output, watched), (0, "", []))
        return messages

    # promises: host-state-is-not-changed, locale-changes-nothing
    def test_whole_library(self):
        """Results in the locale are compared with those of the C locale by the host."""
        messages = self.behaves("comma")
        self.assertEqual(messages[0], "decimal sign ,")
        for number in ("-0.125", "-0.5"):
            self.assertIn(number, "\n".join(messages))
        self.assertNotRegex("\n".join(messages[1:]), r"\d,\d")

    def test_watch_reports_every_call(self):
        with open(os.path.join(SOURCES, "violations.c"), encoding="utf-8") as stream:
            names = re.findall(r"^    DO\((\w+)", stream.read(), re.M)
        self.assertGreater(len(names), 25)
        for name in names:
            with self.subTest(name):
                watched = self.host(how=name)[2]
                self.assertIn(name + " from libtoliman_violations.so", watched)

    # promise: host-state-is-not-changed
    def test_imports(self):
        def imports(library):
            table = subprocess.run(["nm", "-D", "-u", library], check=True, stdout=subprocess.PIPE, universal_newlines=True)
            return {line.split()[-1].split("@")[0] for line in table.stdout.splitlines()}
        self.assertEqual(imports(LIBRARY) & set(FORBIDDEN), set())
        bad = os.path.join(os.path.dirname(LIBRARY), "libtoliman_violations.so")
        self.assertGreater(len(imports(bad) & set(FORBIDDEN)), 20)


if __name__ == "__main__":
    unittest.main()
