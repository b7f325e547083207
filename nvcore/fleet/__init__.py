"""The fleet: stores of many recordings, and the same comparison over all of them."""

from nvcore.subjects import Subject

SUBJECT = Subject(
    name="fleet",
    recording_keys="session:FleetEntry",
    commands="commands:COMMANDS",
    names={
        "ingest": "face:ingest",
        "open_store": "face:open_store",
        "scan": "face:scan",
        "scan_status": "face:scan_status",
        "top": "face:top",
        "export_recording": "face:export_recording",
    },
    extras={
        "fleet": ("deltalake", "duckdb", "obstore", "sqlglot"),
        "dask": ("deltalake", "distributed", "duckdb", "obstore", "sqlglot"),
    },
)
