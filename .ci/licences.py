"""Whether all that the workspace ships is built from may be used with either of its licences: each
package's licence expression (SPDX) must hold with the permissive licences below alone.

Licences alone: advisories come from a database that is fetched from elsewhere.
"""

import json
import re
import subprocess
import sys

ALLOWED = {
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
}


def is_allowed(expression):
    """Of OR any, of AND all; a slash is an old OR."""
    words = re.findall(r"\(|\)|[^\s()]+", expression.replace("/", " OR "))

    def one_of():
        found = all_of()
        while words and words[0] == "OR":
            words.pop(0)
            found = all_of() or found
        return found

    def all_of():
        found = single()
        while words and words[0] == "AND":
            words.pop(0)
            found = single() and found
        return found

    def single():
        word = words.pop(0)
        if word == "(":
            found = one_of()
            words.pop(0)
            return found
        if words[:1] == ["WITH"]:
            words.pop(0)
            return f"{word} WITH {words.pop(0)}" in ALLOWED or word in ALLOWED
        return word in ALLOWED

    return one_of()


def shipped(metadata):
    """The packages that others build with the workspace's: not those of benchmarks and tests."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    packages = {package["id"]: package for package in metadata["packages"]}
    waiting = [id for id in metadata["workspace_members"] if packages[id]["name"] != "bench"]
    found = set(waiting)
    while waiting:
        for dependency in nodes[waiting.pop()]["deps"]:
            kinds = {kind["kind"] for kind in dependency["dep_kinds"]}
            if kinds != {"dev"} and dependency["pkg"] not in found:
                found.add(dependency["pkg"])
                waiting.append(dependency["pkg"])
    return [packages[id] for id in sorted(found)]


def check():
    for expression, wanted in [
        ("MIT OR GPL-3.0", True),
        ("GPL-3.0 OR (MIT AND Zlib)", True),
        ("MIT AND GPL-3.0", False),
        ("(MIT OR Apache-2.0) AND Unicode-3.0", True),
        ("MIT/Apache-2.0", True),
        ("Apache-2.0 WITH LLVM-exception", True),
        ("MPL-2.0", False),
    ]:
        assert is_allowed(expression) == wanted, expression
    command = ["cargo", "metadata", "--format-version", "1", "--locked"]
    metadata = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    packages = shipped(metadata)
    refused = [
        f"{package['name']} {package['version']}: {package['license'] or 'no licence'}"
        for package in packages
        if not (package["license"] and is_allowed(package["license"]))
    ]
    print(f"{len(packages)} packages, {len(refused)} with a licence that is not allowed")
    return refused


if __name__ == "__main__":
    sys.exit("\n".join(check()) or None)
