"""Processes with limits on memory and time, for opening what strangers send.

A file made to fill the memory then ends a job, and not the server. Nothing in here imports
Streamlit: the processes start from it.
"""
