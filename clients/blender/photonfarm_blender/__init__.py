"""Renders Blender's scene on a photonfarm and shows the picture while it converges.

It needs the package photonfarm in Blender's Python; README.md says how to install it.
"""

from . import interface


def register():
    interface.register()


def unregister():
    interface.unregister()
