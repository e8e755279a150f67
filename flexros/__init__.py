"""FlexROS: modelling, control, identification and gap diagnosis of flexible robot manipulators."""
