"""The dashboard: all code that imports streamlit, except the pages."""
