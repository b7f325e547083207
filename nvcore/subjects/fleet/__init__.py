"""The fleet: stores of many recordings, and the same comparison over all of them."""

from nvcore.common.subject import Subject

SUBJECT = Subject(
    name="fleet",
    recording_keys="session:FleetEntry",
    commands="commands:COMMANDS",
    names={
        "ingest": "calls:ingest",
        "open_store": "calls:open_store",
        "scan": "calls:scan",
        "scan_status": "calls:scan_status",
        "top": "calls:top",
        "export_recording": "calls:export_recording",
    },
    extras={
        "fleet": ("deltalake", "duckdb", "obstore", "sqlglot"),
        "dask": ("deltalake", "distributed", "duckdb", "obstore", "sqlglot"),
    },
)
