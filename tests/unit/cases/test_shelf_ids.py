"""Ids of cameras and templates: plain names, and nothing that leads out of the folder."""

import pytest

from limbgram.cases.shelf_ids import is_id, new_id


def test_a_new_id_is_one_and_is_not_made_twice():
    made = {new_id() for _ in range(200)}
    assert len(made) == 200
    assert all(is_id(one) for one in made)


@pytest.mark.parametrize(
    "name",
    ["", "abcd234", "abcd23456", "ABCD2345", "../abc23", "abcd2345\n", "abcd234.", "ab cd234"],
)
def test_another_name_is_no_id(name):
    assert not is_id(name)
