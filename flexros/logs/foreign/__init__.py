"""Import of logs of other recorders: a mapping file assigns columns to topics."""
