"""Tongue meshes from files: formats, frames, attachment and the library that finds them by name."""
