"""Writes a page of the C++ API for each public header, from what Doxygen found in it:

    python3 docs/site/cpp_pages.py XML FOLDER
"""

import sys
from collections import defaultdict
from pathlib import Path
from xml.etree import ElementTree

xml, folder = Path(sys.argv[1]), Path(sys.argv[2])


def text(node):
    return "".join(node.itertext()).strip() if node is not None else ""


def directive(kind, name, *options):
    return f"```{{doxygen{kind}}} {name}\n" + "".join(f":{option}:\n" for option in options) + "```\n"


headers = defaultdict(list)  # parts by header, in the order in which they stand there
for file in [*xml.glob("class*.xml"), *xml.glob("struct*.xml")]:
    of = ElementTree.parse(file).getroot().find("compounddef")
    name, place = text(of.find("compoundname")), of.find("location")
    nested = of.get("prot") != "public" or name.count("::") > 1 or "<" in name or "@" in name
    if not nested and text(of.find("briefdescription")):
        headers[place.get("file")].append((int(place.get("line")), directive(of.get("kind"), name, "members")))
of = ElementTree.parse(xml / "namespacesightline.xml").getroot().find("compounddef")
for member in of.iter("memberdef"):
    kind, name, place = member.get("kind"), text(member.find("name")), member.find("location")
    if not text(member.find("briefdescription")) or kind not in ("function", "enum", "typedef"):
        continue
    types = ", ".join(text(p.find("type")) for p in member.findall("param"))
    arguments = f"({types})" if kind == "function" else ""
    headers[place.get("declfile") or place.get("file")].append(
        (int(place.get("declline") or place.get("line")), directive(kind, f"sightline::{name}{arguments}")))

names = []
for header in sorted(headers):
    names.append(Path(header).stem)
    parts = [part for _, part in sorted(headers[header])]
    (folder / f"{names[-1]}.md").write_text("\n".join([f"# sightline/{names[-1]}.hpp\n", *parts]))
listed = "\n".join(names)
(folder / "index.md").write_text(f"# C++\n\nThe public headers.\n\n```{{toctree}}\n:maxdepth: 1\n\n{listed}\n```\n")
