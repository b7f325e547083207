"""Public Python API (``import nvcore as nv``), with a call for each command of the command line."""
