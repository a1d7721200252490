"""Window, camera, scene and panels: what a session looks like, on screen and in files.

The viewer reads a `SessionView` (session_view.py) and never simulates. `window.run_window` opens the
interactive window, `offscreen.OffscreenRenderer` makes pictures without a display and `movie` writes
them to files; all three draw the same `scene.Scene`.
"""
