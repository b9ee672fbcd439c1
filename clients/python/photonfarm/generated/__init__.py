"""What a coordinator answers, as its OpenAPI document describes it. clients/python/generate.sh writes models.py; nobody edits it."""
