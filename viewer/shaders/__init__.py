"""GLSL, one stage a file."""
