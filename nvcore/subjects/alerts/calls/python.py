"""The call of Python users: `nvcore.judge_alerts`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nvcore.api.calls import compare
from nvcore.api.inputs import load
from nvcore.common.arguments import PathLike
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import write_run
from nvcore.dataset import Dataset
from nvcore.inputs.session import Session
from nvcore.subjects.alerts.policy import policy_from
from nvcore.subjects.alerts.steps import AlertsView, alerts_in

FILES = ("alerts.csv", "alert_curve.csv", "speeding.csv")
"""Files that `write_alerts` writes; the last one only if there are speed alerts."""


def judge_alerts(
    source: PathLike | Session | Dataset, *, policy: PathLike | None = None, **settings: Any
) -> AlertsView:
    """Judge which detections of X and Y reach the driver as alerts, and which ones were worth it.

    Parameters
    ----------
    source
        A session file, a session, or a dataset made by `load`.
    policy
        Policy that turns detections into alerts: ``"cautious"``, ``"balanced"``, ``"eager"``, or a
        TOML file (docs/alerts.md). None: each system's own log if the session names one, else its
        settings. A policy that the session names for a system has priority.
    settings
        Settings of `load`, such as ``alert_pause_s=5`` or ``x="FIR"``. They have priority over the
        policy.

    Returns
    -------
    AlertsView
        View with `table` (a row per alert), `curve`, and the underlying comparison in `result`.

    Raises
    ------
    InputError
        If an input or the policy cannot be used, or there are fewer than two systems.
    ParameterError
        If there is no such setting or policy, or a value is outside its range.

    Examples
    --------
    >>> alerts = judge_alerts("sample_data/session.toml", policy="eager")  # doctest: +SKIP
    >>> alerts.table["kind"].value_counts()  # doctest: +SKIP
    """
    values: dict[str, Any] = {"alerts": "log"}
    if policy is not None:
        values = {"alerts": "policy", **policy_from(policy)}
    return alerts_in(compare(load(source, **{**values, **settings})).result)


def write_alerts(folder: Path, alerts: AlertsView) -> None:
    """Write `FILES` into a folder: the table of alerts, the trade-off curve, the speed alerts.

    Raises
    ------
    InputError
        If the folder cannot be written to, or holds the run of another command.
    """
    curve = alerts.curve.assign(
        threshold=alerts.curve["threshold"].replace(float("-inf"), float("nan"))
    )
    speeding = alerts.speeding
    tables = [*zip(FILES, (alerts.table, curve), strict=False)]
    tables += [(FILES[2], speeding.table)] if speeding is not None else []
    write_run(folder, [(name, to_csv_bytes(table)) for name, table in tables], FILES)
