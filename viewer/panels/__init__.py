"""One imgui panel a file: functions of (PanelContext) that draw into the current imgui window."""
