"""What a call is refused with."""

import pytest

from contbed.errors import SceneError


def refused(match, call, *arguments, **settings):
    """Assert that a call raises a SceneError whose message has the words."""
    with pytest.raises(SceneError, match=match):
        call(*arguments, **settings)


def refusal(call, *arguments, **settings):
    """Return the message of the error that a call raises."""
    with pytest.raises(SceneError) as caught:
        call(*arguments, **settings)
    return str(caught.value)


def problems_of(call, *arguments, **settings):
    """Return the problems of the scene that a call finds."""
    with pytest.raises(SceneError) as caught:
        call(*arguments, **settings)
    return caught.value.problems
