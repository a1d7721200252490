"""One imgui panel a file."""
