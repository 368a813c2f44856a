"""Writes project files of schema 1, one curve point a line, so that people can read and diff them."""
import json


def point(at, tissue):
    return {"at": [round(float(c), 5) for c in at], "tissue": round(float(tissue), 3)}


def curve(name, points, values, start, end):
    """`start`, `end`: ("bone", "femur"), ("plane", "median"), ("tissue", name) or None for a free end."""
    entry = {"name": name} if name else {}
    entry["points"] = [point(p, v) for p, v in zip(points, values)]
    for key, anchor in (("start", start), ("end", end)):
        if anchor:
            entry[key] = {"on": anchor[0], "name": anchor[1]}
    return entry


def _text(value, indent, width=110):
    flat = json.dumps(value, ensure_ascii=False)
    if len(flat) + indent <= width or not isinstance(value, (dict, list)):
        return flat
    pad, inner = " " * indent, " " * (indent + 2)
    if isinstance(value, dict):
        rows = [f"{inner}{json.dumps(k)}: {_text(v, indent + 2, width)}" for k, v in value.items()]
        return "{\n" + ",\n".join(rows) + f"\n{pad}}}"
    rows = [inner + _text(v, indent + 2, width) for v in value]
    return "[\n" + ",\n".join(rows) + f"\n{pad}]"


def save(path, project):
    path.write_text(_text(project, 0) + "\n", encoding="utf-8")
