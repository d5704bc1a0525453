from pathlib import Path

import pytest

from nodes.hmi.places import PlacesError, SavedPlaces, places_file
from nodes.hmi.protocol.values import Pose

MOUTH = Pose((0.3, 0.1, 1.2), (0.0, 0.0, 0.0, 1.0))


def test_places_are_kept_for_the_next_time(tmp_path: Path) -> None:
    file = tmp_path / "state" / "arph.json"
    places = SavedPlaces(file)
    places.save("mouth", MOUTH)
    places.save("table", Pose((0.5, 0.0, 0.7)))
    places.forget("table")
    assert SavedPlaces(file).poses == {"mouth": MOUTH}


def test_they_are_in_the_user_s_folder_for_state(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", "/somewhere")
    assert places_file("arph") == Path("/somewhere/msma/places/arph.json")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{",
        '{"mouth": {"position": [1, 2]}}',
        '{"mouth": {"position": [1, 2, 1e99]}}',
        '{"mouth": {"position": [1, 2, null]}}',
        '{"": {"position": [1, 2, 3]}}',
        '{"mouth": {"position": [1, 2, 3], "orientation": [1, 1, 1, 1]}}',
        "\xff",
    ],
)
def test_a_file_that_makes_no_sense_is_said_and_never_written_over(
    text: str, tmp_path: Path
) -> None:
    file = tmp_path / "arph.json"
    file.write_text(text, encoding="latin-1")
    places = SavedPlaces(file)
    assert str(file) in places.error
    assert places.poses == {}
    with pytest.raises(PlacesError, match=r"arph\.json"):
        places.save("mouth", MOUTH)
    assert file.read_text(encoding="latin-1") == text


def test_what_cannot_be_kept_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("a file where a folder should be")
    places = SavedPlaces(tmp_path / "state" / "arph.json")
    with pytest.raises(PlacesError):
        places.save("mouth", MOUTH)
    assert places.poses == {}
    with pytest.raises(PlacesError, match="no place"):
        places.forget("mouth")
