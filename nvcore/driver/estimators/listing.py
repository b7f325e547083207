"""Entries on estimators for ``nvcore models``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import click

from nvcore.cli.models import Models
from nvcore.driver.estimator_report import render_estimator, render_estimators
from nvcore.driver.estimators.model_file import estimator_path, is_estimator_file, read_estimator


def _described(model: str, settings: Mapping[str, str]) -> str:
    if settings:
        raise click.UsageError("--set: an estimator has no settings")
    return render_estimator(read_estimator(estimator_path(model)))


MODELS: Final = Models(
    list_all=render_estimators,
    has=lambda model: is_estimator_file(estimator_path(model)),
    describe=_described,
)
