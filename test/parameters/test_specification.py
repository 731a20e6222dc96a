# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.laws import GUIDANCE_LAW
from uav_tracking_mpc.parameters.specification import (
    ParameterError,
    Parameters,
    changed,
    from_mapping,
    parameter,
    refuse_fixed,
    specifications,
)


@dataclass(frozen=True)
class Example(Parameters):
    """Parameters of every kind."""

    rate: float = parameter(10.0, "A rate.", "Hz", 1.0, 100.0)
    count: int = parameter(3, "A count.", lower=1, upper=5)
    active: bool = parameter(True, "A switch.")
    kind: str = parameter("a", "A choice.", choices=("a", "b"))
    weights: tuple[float, ...] = parameter((1.0, 2.0), "Weights.", size=2, lower=0.0)
    points: tuple[float, ...] = parameter((0.0, 0.0, 0.0), "Points.", multiple=3)


def test_missing_values_take_their_defaults():
    assert from_mapping(Example, {}) == Example()


def test_an_integer_may_stand_for_a_number():
    value = from_mapping(Example, {"rate": 20}).rate
    assert value == 20.0
    assert isinstance(value, float)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"rate": 0.5}, "parameter 'rate' is 0.5, must be a number from 1 to 100 Hz"),
        ({"rate": float("nan")}, "is nan"),
        ({"rate": float("inf")}, "is inf"),
        ({"rate": "fast"}, "is 'fast'"),
        ({"rate": True}, "is True"),
        ({"rate": None}, "is None"),
        ({"count": 2.0}, "parameter 'count' is 2.0, must be an integer from 1 to 5"),
        ({"count": 6}, "is 6"),
        ({"active": 1}, "must be true or false"),
        ({"kind": "c"}, "must be one of a, b"),
        ({"weights": [1.0]}, "a list of 2 numbers of at least 0"),
        ({"weights": [1.0, -1.0]}, "is .1.0, -1.0."),
        ({"weights": "12"}, "is '12'"),
        ({"weights": [1.0, "x"]}, "must be a list"),
        ({"points": [1.0, 2.0]}, "a multiple of 3"),
        ({"speed": 1.0}, "'speed' is unknown, known are: rate, count"),
    ],
)
def test_what_is_not_allowed_is_named_with_value_and_range(values, message):
    with pytest.raises(ParameterError, match=message):
        from_mapping(Example, values)


SCALARS = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(), st.lists(st.floats())
)


@given(st.sampled_from(specifications(Example)), SCALARS)
def test_any_value_is_either_taken_in_its_own_type_or_refused(specification, value):
    try:
        checked = specification.check(value)
    except ParameterError:
        return
    assert type(checked) is type(specification.default)


def test_every_parameter_of_the_package_is_described_and_its_default_allowed():
    from uav_tracking_mpc.settings.configuration import SECTIONS

    for section in SECTIONS.values():
        for specification in specifications(section):
            assert specification.description.endswith(".")
            assert specification.check(specification.default) == specification.default
            numeric = isinstance(specification.default, (int, float, tuple))
            if numeric and not isinstance(specification.default, bool):
                assert specification.lower is not None, specification.name
                assert specification.upper is not None, specification.name


@dataclass(frozen=True)
class Held(Parameters):
    """Parameters of which one is fixed."""

    kind: str = parameter("plain", "A kind.", choices=("plain", "free"), fixed=True)
    size: float = parameter(1.0, "A size.", lower=0.0, upper=9.0)
    rate: float = parameter(1.0, "A rate.", lower=0.0, upper=9.0)
    law: str = parameter("none", "A law.", choices=("none",), extension=GUIDANCE_LAW.room)


def test_what_is_fixed_says_so_itself():
    refuse_fixed(Held(), Held(rate=2.0, law="l1"))
    with pytest.raises(ParameterError, match="'kind' is 'free', must stay 'plain' while"):
        refuse_fixed(Held(), Held(kind="free"))
    with pytest.raises(ParameterError, match="'size' is 2.0, must stay 1.0 for now"):
        refuse_fixed(Held(), Held(size=2.0), "for now", ["rate", "size"])
    refuse_fixed(Held(), Held(kind="free"), "for now", ["rate", "size"])


def test_a_change_is_checked_as_every_value_is():
    assert changed(Held(rate=3.0), {"size": 2}) == Held(rate=3.0, size=2.0)
    with pytest.raises(ParameterError, match="'size' is 10.0, must be a number from 0 to 9"):
        changed(Held(), {"size": 10.0})


@pytest.mark.parametrize("law", ["none", "l1", "vector_field", "path.py:Class"])
def test_an_extension_may_stand_beside_choices(law):
    assert from_mapping(Held, {"law": law}).law == law


def test_what_is_neither_a_choice_nor_an_extension_is_refused():
    with pytest.raises(ParameterError, match="must be one of none, l1, .*, or path.py:Class"):
        from_mapping(Held, {"law": "l2"})
