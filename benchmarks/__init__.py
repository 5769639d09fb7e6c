"""What the project's parts cost, measured beside others that do the same job."""
