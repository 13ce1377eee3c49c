#!/usr/bin/env bash
# Builds the site of the documents, the notebooks, and the API of C++ and of Python:  scripts/site.sh [FOLDER]   (build/site if not said)
# Needs the release preset with the Python module, and what scripts/deps.sh installs for tests. Open
# FOLDER/index.html. A link within the site that leads nowhere ends it with exit code 1, and so does
# a notebook that fails.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(realpath -m "${1:-build/site}")
source=$folder.source
module=build/release/python
[[ -d $module/sightline ]] || { echo "$module/sightline is missing, expected the release preset with the Python module (docs/install.md)"; exit 1; }
python=$(sed -n 's/^Python_EXECUTABLE:[A-Z]*=//p' build/release/CMakeCache.txt)
command -v doxygen >/dev/null || { echo 'doxygen is missing; scripts/deps.sh test installs it'; exit 1; }

rm -rf "$folder" "$source"
mkdir -p "$source/docs/api/cpp" "$folder"
cp -a docs "$source/"
cp -a examples scenarios CMakeLists.txt "$source/"
sed 's#(docs/#(#g; s#(\([A-Z]*\.md\))#(../\1)#g' CONTRIBUTING.md >"$source/docs/contributing.md"
sed -i 's#(../CONTRIBUTING.md)#(contributing.md)#g' "$source"/docs/*.md

(cat docs/site/Doxyfile; echo "INPUT = include/sightline"; echo "OUTPUT_DIRECTORY = $source/doxygen") | doxygen - >/dev/null

printf '# Python\n\n```{eval-rst}\n.. automodule:: sightline\n   :members:\n   :imported-members:\n   :undoc-members:\n\n.. automodule:: sightline.plot\n   :members:\n```\n' \
  >"$source/docs/api/python.md"
"$python" docs/site/cpp_pages.py "$source/doxygen/xml" "$source/docs/api/cpp"

log=$folder.log
PYTHONPATH=$PWD/$module "$python" -m sphinx -q -j auto -b html -c "$source/docs/site" -D "breathe_projects.sightline=$source/doxygen/xml" \
  "$source/docs" "$folder" 2>"$log" || { tail -n 30 "$log"; exit 1; }
grep -E 'myst|not found|nonexisting|unknown document' "$log" | grep -v '/api/' && { echo "$log has links that lead nowhere"; exit 1; }

"$python" - "$folder" <<'PY'
import html.parser, sys, urllib.parse
from pathlib import Path

root = Path(sys.argv[1]).resolve()
pages = {}


class Page(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.links, self.ids = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        of = dict(attributes)
        self.ids |= {of[key] for key in ("id", "name") if of.get(key)}
        self.links += [of[key] for key in ("href", "src") if of.get(key)]


for file in root.rglob("*.html"):
    pages[file] = Page(file.read_text())
bad, links = [], 0
for file, page in pages.items():
    for link in page.links:
        parts = urllib.parse.urlsplit(link)
        if parts.scheme or parts.netloc:
            continue
        links += 1
        target = (file.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else file
        if not target.exists() or (parts.fragment and target in pages and urllib.parse.unquote(parts.fragment) not in pages[target].ids):
            bad.append(f"{file.relative_to(root)}: {link} leads nowhere")
print("\n".join(bad))
print(f"{len(pages)} pages, {links} links within the site, {len(bad)} lead nowhere")
sys.exit(bool(bad) or not links)
PY
