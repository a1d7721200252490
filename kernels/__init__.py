"""Warp kernels only: arrays in, arrays out."""
