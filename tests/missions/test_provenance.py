"""What a file may say of where its numbers come from."""

import pytest

from missions.files.errors import InputError
from missions.files.overrides import with_overrides
from missions.files.validation import validate
from missions.files.yaml import Document
from missions.provenance import Provenance

FITTED = {"key": "modules.area_m2", "value": 1.4, "before": 1.5}
FITTED |= {"standard_error": 0.01, "low": 1.38, "high": 1.42}
WRITTEN = {"tool": "other 1.0", "date": "2024-05-01", "aircraft": "as2.yaml", "fitted": [FITTED]}


def test_provenance_is_kept_as_it_is_written():
    read = validate(Document("file.yaml", WRITTEN), Provenance)
    assert read.fitted[0].before == 1.5
    assert read.model_dump(mode="json", exclude_unset=True) == WRITTEN


def test_mistakes_in_provenance_are_told():
    wrong = with_overrides(Document("file.yaml", WRITTEN), {"logs": "flight.csv", "date": 3})
    with pytest.raises(InputError) as told:
        validate(wrong, Provenance)
    assert [problem.key for problem in told.value.problems] == ["date", "logs"]
