"""Pictures and datasets on many machines, by engines that exist."""
