"""Gap monitor: the nominal robot beside a running one, how far both are apart, where, and when that is an alarm."""
