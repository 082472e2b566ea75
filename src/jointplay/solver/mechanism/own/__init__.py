"""Systems of somebody's own equations: records, checks, assembly."""
