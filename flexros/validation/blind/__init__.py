"""The blind check: logs with hidden deviations, made with numerics of their own, diagnosed and scored apart."""
