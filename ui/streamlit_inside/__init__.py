"""What is known of Streamlit's insides: no other room imports them.

Each trick has a test in ``tests/ui/streamlit_inside``, which fails where a later Streamlit changes
that place. The versions that all of it holds for stand in ``pyproject.toml``. The scripts act on
Streamlit's page:

    history.js   wraps ``history.pushState``, which Streamlit calls for each change of the address
    narrow.js    presses Streamlit's button that folds the sidebar, takes back what it then stores
    theme.js     watches the element whose ground Streamlit changes with the theme
"""

from pathlib import Path
from typing import Final

SCRIPTS: Final = Path(__file__).parent
