"""The dashboard: everything but the pages that imports streamlit."""
