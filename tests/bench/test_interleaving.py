from bench.interleaving import interleaved, ratio


def test_the_systems_take_turns_and_none_is_always_first() -> None:
    order: list[str] = []
    measured = interleaved(
        {"a": lambda: order.append("a"), "b": lambda: order.append("b")}, rounds=3
    )
    assert order == ["a", "b", "b", "a", "a", "b"]
    assert {name: len(results) for name, results in measured.items()} == {"a": 3, "b": 3}


def test_a_ratio_compares_each_round_with_itself() -> None:
    found = ratio([2.0, 30.0, 3.0], [1.0, 10.0, 2.0])
    assert (found.least, found.median, found.most) == (1.5, 2.0, 3.0)
    assert found.text() == "2.00 x (1.50 to 3.00)"
