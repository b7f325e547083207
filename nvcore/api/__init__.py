"""What ``import nvcore as nv`` offers: a call for each thing that the command line does."""
