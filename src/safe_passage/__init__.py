"""Perception for mobile robots that share their space with people."""

from pkgutil import extend_path

# In a workspace's devel space the compiled modules and messages lie in a folder of their own. A
# spawned process finds this folder first, and through it those.
__path__ = extend_path(__path__, __name__)
