"""One class of arguments is the flags of a command and the keywords of a Python call."""

from __future__ import annotations

import inspect
from dataclasses import KW_ONLY
from typing import Any

import click
import pytest
from click.testing import CliRunner

from nvcore.cli.options import arguments_of, options_of
from nvcore.common.arguments import Part, argument, arguments, called_with, method_with, pairs_of


@arguments
class Wishes:
    place: str
    many: str = argument("A", "How many; see {late_s}.", flag="--how-many")
    _: KW_ONLY
    late_s: float = argument("A", "How late.", default=0.5)
    names: tuple[str, ...] = argument("B", "{again}.", flag="--of", default=(), multiple=True)
    facts: dict[str, str] | None = argument(
        "B", "What.", default=None, multiple=True, callback=pairs_of
    )
    silent: bool = False


@called_with(Wishes)
def call(wishes: Wishes) -> Wishes:
    """Wish.

    Parameters
    ----------
    place, silent
        Where, and whether quietly.

    Raises
    ------
    TypeError
        If there is no such wish.
    """
    return wishes


class Owner:
    @method_with(Wishes)
    def call(self, wishes: Wishes) -> tuple[Owner, Wishes]:
        return self, wishes


@click.command
@options_of(Wishes)
def command(**options: Any) -> None:
    click.echo(arguments_of(Wishes, {**options, "place": "here", "silent": False}))


def test_a_call_has_the_fields_as_its_parameters():
    parameters = dict(inspect.signature(Wishes).parameters)
    assert dict(inspect.signature(call).parameters) == parameters
    assert [*inspect.signature(Owner.call).parameters] == ["self", *parameters]
    assert inspect.signature(call).return_annotation == "Wishes"
    assert call.__name__ == "call"
    assert call.__doc__ == (
        "Wish.\n\nParameters\n----------\nplace, silent\n    Where, and whether quietly.\n"
        "many\n    How many; see `late_s`.\nlate_s\n    How late.\nnames\n    several may be given."
        "\nfacts\n    What.\n\nRaises\n------\nTypeError\n    If there is no such wish."
    )
    assert call("here", "3", late_s=1) == Wishes("here", "3", late_s=1)
    owner = Owner()
    assert owner.call("here", many="3") == (owner, Wishes("here", "3"))
    with pytest.raises(TypeError, match="unexpected keyword argument 'early_s'"):
        call("here", "3", early_s=1)  # type: ignore[call-arg]


def test_a_command_has_the_fields_that_have_flags():
    given = ("--how-many", "3", "--of", "a", "--of", "b", "--facts", "k = 1", "--facts", "l=2=3")
    result = CliRunner().invoke(command, given)
    facts = {"k": "1", "l": "2=3"}
    assert result.stdout == f"{Wishes('here', '3', names=('a', 'b'), facts=facts)}\n"
    result = CliRunner().invoke(command, ("--how-many", "3"))
    assert result.stdout == f"{Wishes('here', '3', facts={})}\n"


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((), "Missing option '--how-many'"),
        (("--how-many", "3", "--late-s", "soon"), "'soon' is not a valid float"),
        (("--how-many", "3", "--facts", "k"), "--facts: expected KEY=VALUE, found 'k'"),
        (("--how-many", "3", "--facts", "=1"), "--facts: expected KEY=VALUE, found '=1'"),
    ],
)
def test_a_flag_that_is_lacking_or_wrong_is_said(given: tuple[str, ...], words: str):
    result = CliRunner().invoke(command, given)
    assert result.exit_code == 2
    assert words in result.stderr


def test_flags_stand_in_the_order_of_the_call_and_may_be_chosen():
    names = [option.name for option in command.params]
    assert names == ["many", "late_s", "names", "facts"]
    chosen = click.command(options_of(Part, "size", "tags")(lambda **_: None))
    assert [option.name for option in chosen.params] == ["tags", "size"]
    text = CliRunner().invoke(command, "--help").stdout
    for words in ("[default: 0.5]", "How many; see --late-s.", "may be given again."):
        assert words in text
