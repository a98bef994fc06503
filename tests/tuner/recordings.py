"""Reading a recording in a test, and what it is refused with."""

import pytest

from tuner.data.logs import LogError
from tuner.data.reading import read_record


def refusal(*arguments, reader=read_record, **options):
    """The sentence with which something is refused: one line, without a folder's name."""
    with pytest.raises(LogError) as caught:
        reader(*arguments, **options)
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert not hasattr(arguments[0], "parent") or str(arguments[0].parent) not in sentence
    return sentence


def values(path, text, **options):
    """The only channel that is read."""
    (signal,) = read_record(path, [text], **options).channels.values()
    return signal.values
