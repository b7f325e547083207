"""All dependencies on Streamlit's internals. No other package imports them.

Each one has a test in ``tests/ui/streamlit_inside`` that fails if a later Streamlit changes the
internals. ``pyproject.toml`` has the supported versions. The scripts act on Streamlit's page:

    history.js   wraps ``history.pushState``, which Streamlit calls for each change of the address
    narrow.js    presses Streamlit's button that folds the sidebar, and undoes what it then stores
    theme.js     watches the element whose background Streamlit changes with the theme
"""

from pathlib import Path
from typing import Final

SCRIPTS: Final = Path(__file__).parent
