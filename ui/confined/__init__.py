"""Processes with limits on memory and time, for opening untrusted files.

A file made to fill the memory then ends a process, not the server. Nothing in here imports
Streamlit, as the processes are forked from it.
"""
