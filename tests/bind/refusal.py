"""Refused calls, by what a program sees of them: the type of the exception and the name of what was wrong."""
import contextlib
import re


def name_in(error):
    """The `field` of an error of the library; the first word of the message of others, which is the argument."""
    field = getattr(error, "field", None)
    return re.split("[ :]", str(error))[0] if field is None else field


@contextlib.contextmanager
def refused(kind, name=""):
    try:
        yield
    except kind as error:
        if name_in(error) != str(name):
            raise AssertionError(f"{error!r} names {name_in(error)!r}: expected {name!r}") from error
    else:
        raise AssertionError(f"{kind} was not raised: {name}")
