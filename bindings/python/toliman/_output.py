"""Output files that appear whole or not at all, as those of the program."""
from __future__ import annotations

import contextlib
import fcntl
import os
import pathlib
import signal
import stat
import sys
import threading
import typing

from ._failure import OUTPUT, Failure, readable

STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextlib.contextmanager
def signals_deferred() -> typing.Iterator[list[int]]:
    """Signals that Python code handles are handled after the block, which gets the list of them: it completes its files or
    removes them. Python allows this on the main thread, which alone handles signals."""
    numbers = [number for number in STOPS
               if callable(signal.getsignal(number)) and threading.current_thread() is threading.main_thread()]
    received: list[int] = []
    before = {number: signal.signal(number, lambda number, _: received.append(number)) for number in numbers}
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if received:
        signal.raise_signal(received[0])


class SignalWatch:
    """Ends the process at once when a signal asks it to stop, also during a long call of the library, after clean_up().
    Made by the main thread before it starts others. Work that a signal must not interrupt holds `lock`."""

    def __init__(self, message: str):
        self.lock = threading.RLock()
        self._message, self._work = message, contextlib.ExitStack()
        self._numbers = [number for number in STOPS if signal.getsignal(number) != signal.SIG_IGN]
        signal.pthread_sigmask(signal.SIG_BLOCK, self._numbers)
        threading.Thread(target=self._wait, daemon=True).start()

    def at_end(self, work: typing.Callable[[], typing.Any]) -> None:
        """Adds work for clean_up(), before that added earlier."""
        self._work.callback(work)

    def clean_up(self) -> None:
        """Does the work of at_end(); a folder that is not empty remains."""
        with contextlib.suppress(OSError):
            self._work.close()

    def _wait(self) -> None:
        number = signal.sigwait(self._numbers)
        with self.lock:
            self.clean_up()
            print(f"toliman: {self._message}", file=sys.stderr, flush=True)
            os._exit(128 + number)


def make_folder(folder: pathlib.Path) -> bool:
    """Makes a folder; false if it exists."""
    try:
        folder.mkdir()
        return True
    except FileExistsError:
        pass
    except OSError as error:
        raise Failure(OUTPUT, f"{readable(folder)}: cannot be created: {error.strerror}") from None
    if not folder.is_dir():
        raise Failure(OUTPUT, f"{readable(folder)}: is not a folder")
    return False


def check_free(target: pathlib.Path) -> None:
    """Fails for a file that is not empty."""
    if target.exists() and not (target.is_file() and target.stat().st_size == 0):
        raise Failure(OUTPUT, f"{readable(target)}: exists and was not written by toliman: give --force to replace it")


def replace_files(files: typing.Mapping[pathlib.Path, bytes], received: typing.Sequence[int] = ()) -> bool:
    """Writes all files and makes their folders, or none if a signal was received before the last is written; whether it
    did. The last file, which implies the others, is renamed last."""
    made = [folder for folder in sorted({path.parent for path in files}, key=lambda path: len(path.parts))
            if make_folder(folder)]
    written: list[tuple[Temporary, pathlib.Path]] = []
    target = pathlib.Path()
    try:
        for target, data in files.items():
            if received:
                return False
            written.append((Temporary(target, data), target.resolve()))
        for temporary, target in written:
            os.replace(temporary.path, target)
        made.clear()
        return True
    except OSError as error:
        raise Failure(OUTPUT, f"{readable(target)}: cannot be written: {error.strerror}") from None
    finally:
        for temporary, _ in written:
            temporary.close()
        for folder in reversed(made):
            folder.rmdir()


class Temporary:
    """Data next to its target, in a file that is locked until close(), which removes it unless it was renamed. Files that
    are not locked were left by processes that died; they are removed. As lib/backend/temporary.cpp."""

    def __init__(self, target: pathlib.Path, data: bytes) -> None:
        target = target.resolve()
        names = [target.with_name(f"{target.name}.{number}.tmp") for number in range(100)]
        for name in names:
            _remove_if_stale(name)
        for self.path in names:
            try:
                self.file = open(self.path, "xb", buffering=0)
            except FileExistsError:
                continue
            if try_lock(self.file) and has_name(self.file, self.path):
                break
            self.file.close()
        else:
            raise Failure(OUTPUT, f"{readable(target)}: cannot be written: 100 temporary files are in the way")
        try:
            view = memoryview(data)
            while view:
                view = view[self.file.write(view):]
            os.fsync(self.file.fileno())
            if target.exists():
                self.path.chmod(target.stat().st_mode & 0o777)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        if has_name(self.file, self.path):
            self.path.unlink(missing_ok=True)
        self.file.close()


def try_lock(file: typing.IO[bytes]) -> bool:
    """False if another process has locked the file; true also on a file system without locks."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True


def has_name(file: typing.IO[bytes], path: pathlib.Path) -> bool:
    """Whether the path still leads to the open file."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.lstat())
    except OSError:
        return False


def _remove_if_stale(path: pathlib.Path) -> None:
    try:
        with open(os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC), "rb", buffering=0) as file:
            status = os.fstat(file.fileno())
            if stat.S_ISREG(status.st_mode) and status.st_uid == os.geteuid():
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if has_name(file, path):
                    path.unlink()
    except OSError:
        pass


def print_text(text: str) -> None:
    """Writes to standard output. A closed pipe is a failure without a message."""
    view = memoryview(text.encode(errors="replace"))
    try:
        while view:
            view = view[os.write(1, view):]
    except BrokenPipeError:
        raise Failure(OUTPUT, "") from None
    except OSError as error:
        raise Failure(OUTPUT, f"standard output: {error.strerror}") from None
