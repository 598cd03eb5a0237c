"""Prints the licences of everything that is linked into the program for a target, with their texts.

    python3 dist/licences.py TARGET
"""

import json
import pathlib
import subprocess
import sys

TEXTS = ("LICENSE*", "LICENCE*", "COPYING*", "NOTICE*", "UNLICENSE*", "license*")


def linked(target: str) -> list[dict]:
    """Packages that the program depends on by itself, not for its build or its tests."""
    words = ["cargo", "metadata", "--format-version", "1", "--all-features", "--locked", "--filter-platform", target]
    found = json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)
    packages = {package["id"]: package for package in found["packages"]}
    nodes = {node["id"]: node for node in found["resolve"]["nodes"]}
    (root,) = (package["id"] for package in found["packages"] if package["name"] == "motorlab")
    reached, open_ids = set(), [root]
    while open_ids:
        at = open_ids.pop()
        if at in reached:
            continue
        reached.add(at)
        for dependency in nodes[at]["deps"]:
            is_linked = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            is_macro = any("proc-macro" in target["kind"] for target in packages[dependency["pkg"]]["targets"])
            if is_linked and not is_macro:
                open_ids.append(dependency["pkg"])
    return sorted((packages[at] for at in reached if packages[at]["source"]), key=lambda one: (one["name"], one["version"]))


def inside() -> list[tuple[str, pathlib.Path]]:
    """What others wrote that is kept in the source: its title, and the file of its licence beside it."""
    root = pathlib.Path(__file__).resolve().parent.parent / "src"
    licences = sorted(root.rglob("LICENSE"))
    return [((path.parent / "README.md").read_text(encoding="utf-8").splitlines()[0].lstrip("# "), path) for path in licences]


def main() -> None:
    packages = linked(sys.argv[1])
    print("Licences of what motorlab is linked with\n")
    for package in packages:
        print(f"{package['name']} {package['version']}: {package['license'] or 'see its text'}")
    for name, path in inside():
        print(f"{name}: {path.read_text(encoding='utf-8').splitlines()[0]}")
    # A text that several have stands once.
    bearers: dict[str, list[str]] = {}
    for package in packages:
        folder = pathlib.Path(package["manifest_path"]).parent
        for path in sorted({path for pattern in TEXTS for path in folder.glob(pattern) if path.is_file()}):
            text = path.read_text(encoding="utf-8", errors="replace").strip()
            bearers.setdefault(text, []).append(f"{package['name']} {package['version']}")
    for name, path in inside():
        bearers.setdefault(path.read_text(encoding="utf-8").strip(), []).append(name)
    for text, names in bearers.items():
        print(f"\n{'=' * 80}\n{', '.join(names)}\n{'=' * 80}\n\n{text}")


if __name__ == "__main__":
    main()
