"""The live page: an interactive view of the neck, solved for every frame.

`controls` says what can be moved, `scene` turns a request into what is drawn, `server` talks to the browser, and
``page.html``, ``page.css``, ``page.js`` draw.
"""

from .scene import Scene
from .server import Page

__all__ = ["Page", "Scene"]
