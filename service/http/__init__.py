"""What `service.app` needs of HTTP: problems, limits, negotiation, the upload, and the documentation page."""
