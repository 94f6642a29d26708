"""HTTP endpoints: thin, one file per resource."""
