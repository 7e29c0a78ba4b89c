"""Offline page: the explorer's own parts, with tables in place of its server, in one file."""

from __future__ import annotations

import base64
import hashlib
import html
import re
from importlib import resources

from missions.files.writing import to_json
from solar._version import __version__
from studies.explorer.offline.record import offline_record
from studies.explorer.session import Session

# The foot says once why most settings are fixed.
_STYLE = "#offline { margin: 0 14px 10px; } .field.fixed .message { display: none; }"
_IMPORT = re.compile(r'^import \{([^}]*)\} from "\./([\w.]+)";\n', re.M)
_EXPORT = re.compile(r"^export (?=(?:class|const|let|(?:async )?function) (\w+))", re.M)
_FOOT = """\
<section class="panel" id="offline" aria-labelledby="offline-title">
<h2 id="offline-title">A page without a server</h2>
<p>Written by solar-uav {version} for {aircraft} on {mission}. The page interpolates in tables of
light and of designs, and computes the battery's day itself. <span id="offline-errors"></span>
Endurance is that of launches five minutes apart. Settings in grey are fixed here. This page does
not check whether a design is within the ranges of the models; an analysis of it does.</p>
</section>
"""


def offline_page(session: Session) -> str:
    """HTML of a page that needs no server, no other file and no network.

    Returns HTML. Its content security policy allows its own scripts alone and no connection.
    """
    record = offline_record(session)
    parts = _parts()
    page = parts["index.html"]
    foot = _FOOT.format(
        version=__version__,
        aircraft=html.escape(session.aircraft.name),
        mission=html.escape(session.mission.name),
    )
    # JSON in a script element: no text of a file may end it.
    tables = to_json(record, separators=(",", ":")).replace("<", "\\u003c")
    scripts = [parts["vendor/uPlot.iife.min.js"], bundled(parts, "main.js")]
    styles = [parts["vendor/uPlot.min.css"], parts["explorer.css"], _STYLE]
    icon = base64.b64encode(parts["icon.svg"].encode()).decode("ascii")
    head = [
        f'<meta http-equiv="Content-Security-Policy" content="{_policy(scripts, styles)}">',
        *(f"<style>{style}</style>" for style in styles),
    ]
    page = re.sub(r'<link rel="stylesheet"[^>]*>\n|<script [^>]*src=[^>]*></script>\n', "", page)
    page = page.replace('"icon.svg"', f'"data:image/svg+xml;base64,{icon}"')
    page = page.replace('id="save">', 'id="save" hidden>')
    page = page.replace("</head>", "\n".join([*head, "</head>"]))
    page = page.replace("<footer>", f"{foot}<footer>")
    last = [
        f'<script type="application/json" id="offline-tables">{tables}</script>',
        f"<script>{scripts[0]}</script>",
        f'<script type="module">{scripts[1]}</script>',
    ]
    return page.replace("</body>", "\n".join([*last, "</body>"]))


def bundled(parts: dict[str, str], entry: str) -> str:
    """Modules as a single one: browsers load no module from another file without a server.

    ``parts``: text of the modules by name; they import by lines ``import { a, b as c } from
    "./x.js";`` and export what they declare. Returns one module, each part a function of its own.
    """
    done: dict[str, str] = {}

    def add(name: str) -> None:
        text = parts[name]
        if re.search(r"^(import|export) ", _EXPORT.sub("", _IMPORT.sub("", text)), re.M):
            raise ValueError(f"{name}: a form of import or export that is not bundled")
        for _, needed in _IMPORT.findall(text):
            if needed not in done:
                add(needed)
        names = ", ".join(_EXPORT.findall(text))
        body = _EXPORT.sub("", _IMPORT.sub(_taken, text))
        done[name] = f"const {_variable(name)} = (() => {{\n{body}\nreturn {{ {names} }};\n}})();\n"

    add(entry)
    return "".join(done.values())


def _taken(match: re.Match[str]) -> str:
    names = re.sub(r"(\w+) as (\w+)", r"\1: \2", match[1])
    return f"const {{{names}}} = {_variable(match[2])};\n"


def _variable(name: str) -> str:
    return "module_" + name.removesuffix(".js").replace(".", "_")


def _parts() -> dict[str, str]:
    """Files of the explorer's page, and the offline page's own in place of those of their names."""
    parts = {}
    static = resources.files("studies.explorer") / "static"
    own = resources.files("studies.explorer.offline")
    for folder, prefix in ((static, ""), (static / "vendor", "vendor/"), (own, "")):
        for file in folder.iterdir():
            if file.name.endswith((".js", ".css", ".html", ".svg")):
                parts[prefix + file.name] = file.read_text(encoding="utf-8")
    return parts


def _policy(scripts: list[str], styles: list[str]) -> str:
    def hashes(texts: list[str]) -> str:
        digests = (hashlib.sha256(text.encode()).digest() for text in texts)
        return " ".join(f"'sha256-{base64.b64encode(d).decode('ascii')}'" for d in digests)

    return (
        f"default-src 'none'; script-src {hashes(scripts)}; style-src {hashes(styles)}; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
