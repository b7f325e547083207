"""What strangers send is opened in processes of their own, with limits on memory and time.

A file made to fill the memory then ends a job, and not the server. Nothing in here imports
Streamlit: the processes start from it.
"""
