"""Report of an identification: one section per file, one HTML page that opens offline."""
