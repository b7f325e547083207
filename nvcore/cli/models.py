"""``nvcore models``: the models that subjects provide."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import click

from nvcore.cli.options import command, grouped_option
from nvcore.common.arguments import pairs_of
from nvcore.common.subject import subjects


@dataclass(frozen=True)
class Models:
    """Functions that list and describe models of one kind.

    Attributes
    ----------
    list_all
        Returns the list of built-in models as text.
    has
        True if its argument is the name or the file of such a model.
    describe
        Returns the description of a model, by its name or file and the given settings.
    """

    list_all: Callable[[], str]
    has: Callable[[str], bool]
    describe: Callable[[str, Mapping[str, str]], str]


@command(
    "List the models, or describe one.",
    "nvcore models",
    "nvcore models hog:daimler",
    "nvcore models yolo.onnx",
    "nvcore models estimator.npz",
)
@click.argument("model", required=False, metavar="[NAME|FILE]")
@grouped_option(
    "Model",
    "--set",
    "settings",
    multiple=True,
    metavar="KEY=VALUE",
    callback=pairs_of,
    help="A setting of the model, such as upscale=2; may be given again.",
)
def models(model: str | None, settings: dict[str, str]) -> None:
    """List the models that are built in, or describe one: by its NAME, or the FILE it is in.

    What it was trained on, what it takes, and its settings with their meaning; icf: every setting
    of nvcore train.
    """
    kinds = [kind for subject in subjects() for kind in subject.models()]
    if model is None:
        if settings:
            raise click.UsageError("--set is about a model; name it")
        for kind in kinds:
            click.echo(kind.list_all())
        return
    # an unknown model is refused by the first kind, with reasons
    kind = next((kind for kind in kinds if kind.has(model)), kinds[0])
    click.echo(kind.describe(model, settings))
