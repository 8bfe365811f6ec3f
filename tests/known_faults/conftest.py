"""What every case of this folder may ask for."""

import pytest


@pytest.fixture
def folder(tmp_path_factory):
    """Return a folder whose name, which messages repeat, says nothing of the case."""
    return tmp_path_factory.mktemp("t")
