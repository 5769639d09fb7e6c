"""The page at `/docs`: the OpenAPI description as plain HTML. It runs no script and asks no other host for anything."""

import json
from html import escape
from typing import Any, Final

CONTENT_SECURITY_POLICY: Final = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"

_STYLE: Final = """
:root { color-scheme: light dark; }
body { font: 1rem/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h2 { margin-top: 2.5rem; } h2 code { font-size: 1.1rem; } h3 { margin-bottom: .3rem; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: .3rem .6rem; }
tr { border-bottom: 1px solid #8886; } pre { overflow-x: auto; padding: .8rem; border: 1px solid #8886; }
"""


def documentation_page(schema: dict[str, Any]) -> str:
    """The HTML page of an OpenAPI description."""
    operations = "".join(
        _operation(method, path, operation)
        for path, methods in schema["paths"].items()
        for method, operation in methods.items()
    )
    info = schema["info"]
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(info['title'])}</title><style>{_STYLE}</style></head><body>"
        f"<main><h1>{escape(info['title'])}</h1><p>{escape(info['description'])}</p>"
        '<p>The same for machines: <a href="openapi.json">openapi.json</a>.</p>'
        f"{operations}</main></body></html>"
    )


def _operation(method: str, path: str, operation: dict[str, Any]) -> str:
    return (
        f"<h2><code>{escape(method.upper())} {escape(path)}</code> {escape(operation['summary'])}</h2>"
        f"<p>{escape(operation.get('description', ''))}</p>{_inputs(operation)}{_responses(operation)}"
    )


def _inputs(operation: dict[str, Any]) -> str:
    rows = [
        (parameter["name"], parameter["in"], parameter.get("description", ""))
        for parameter in operation.get("parameters", [])
    ]
    for media_type, content in operation.get("requestBody", {}).get("content", {}).items():
        for name, field in content["schema"]["properties"].items():
            rows.append((name, media_type, field.get("description", "")))
    return f"<h3>Request</h3>{_table(('Name', 'Where', 'Meaning'), rows)}" if rows else ""


def _responses(operation: dict[str, Any]) -> str:
    rows = []
    examples = []
    for status, response in operation["responses"].items():
        contents = response.get("content", {})
        rows.append((status, response["description"], ", ".join(contents)))
        for media_type, content in contents.items():
            if "example" in content:
                text = escape(json.dumps(content["example"], indent=2, ensure_ascii=False))
                title = f"{escape(status)} {escape(media_type)}"
                examples.append(f"<details><summary>Example: {title}</summary><pre>{text}</pre></details>")
    return f"<h3>Response</h3>{_table(('Status', 'Meaning', 'Media type'), rows)}{''.join(examples)}"


def _table(head: tuple[str, ...], rows: list[tuple[str, str, str]]) -> str:
    titles = "".join(f'<th scope="col">{escape(title)}</th>' for title in head)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table>"
