"""Entries of a session about a system's alerts: its own log, and a policy of its own.

[[system]]
alerts = "fir_alerts.csv"    start_s,end_s,kind[,track][,recording]; or its file of detections,
                             with a column alerted
alert_policy = "fir.toml"    settings of alerts for this system alone
"""

from __future__ import annotations

from dataclasses import dataclass

from nvcore.inputs.facts import path_field


@dataclass(frozen=True, kw_only=True)
class SystemAlerts:
    """Entries of a ``[[system]]`` about its alerts, None if missing.

    Attributes
    ----------
    alerts
        CSV of its alerts, or its file of detections with a column ``alerted``.
    alert_policy
        TOML file of its policy (`nvcore.subjects.alerts.policy`).
    """

    alerts: str | None = path_field(
        "CSV of the alerts that {system} itself gave, for alerts by its own log: start_s,end_s,kind"
        "[,track][,recording]. Default: the session's, or a column alerted of its detections.",
        label="Its own log of alerts (CSV: start_s,end_s,kind)",
        is_of_run=True,
    )
    alert_policy: str | None = path_field(label="Its policy of alerts (TOML)")
