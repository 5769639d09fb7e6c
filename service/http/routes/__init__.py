"""The routes, by what they answer; each stands under its plain path and under /v1."""
