"""The installation of FlexROS on this machine: what `flexros doctor` checks and what `flexros clean` removes."""
