"""The table of results in Markdown: one column group per machine. Shared by bench.py, which prints it, and record.py,
which writes it to the documents."""
import re


def number(value, form):
    return "" if value is None else format(value, form)


def seconds(value):
    """In s, ms or us, depending on the value."""
    for unit, size in (("s", 1), ("ms", 1e-3), ("us", 1e-6)):
        if value >= size:
            break
    return f"{value / size:.3g} {unit}"


def spread(row):
    if "spread" not in row:
        return ""
    part = row["spread"] / row["seconds"]
    return f" +- {part:.0%}" if part >= 0.005 else " +- <1%"


def time(row):
    """For example "5.2 s +- 1%, wall 4.1 s, 110 MB"; nothing for a row that is not there."""
    if not row:
        return ""
    wall = f", wall {seconds(row['wall_seconds'])}" if "wall_seconds" in row else ""
    memory = f", {row['memory_bytes'] / 1e6:.0f} MB" if "memory_bytes" in row else ""
    return seconds(row["seconds"]) + spread(row) + wall + memory


def error(row):
    """For example "1e-9 of peak at 196 pixels", or "1.02 of sigma, rms, largest 2.9, at 100 frames"."""
    if "error" not in row:
        return ""
    value = format(row["error"], ".0e" if row["error"] < 0.1 else ".3g")
    largest = f", largest {row['error_largest']:.2g}," if "error_largest" in row else ""
    at = "at " + row["error_at"] if "error_at" in row else ""
    return " ".join(word for word in (value, row.get("error_of", "") + largest, at) if word)


def processor(machine):
    """Name of the processor, without marks and the word itself."""
    return " ".join(re.sub(r"\(R\)|\(TM\)|\bProcessor\b", "", machine["cpu"]).split())


def markdown(results, wanted=lambda row: row["headline"]):
    """The rows of all results that are wanted: those of the first result, then those that only the others have. Error
    and reference are of the first result that has them."""
    of = [{row["what"]: row for row in one["rows"] if wanted(row)} for one in results]
    names = [f"{processor(one['machine'])}: " for one in results] if len(results) > 1 else [""]
    heads = ["what", "error", "reference"] + [head for name in names for head in (name + "time", "speed-up", "x roofline")]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for what in dict.fromkeys(what for rows in of for what in rows):
        rows = [one.get(what) for one in of]
        there = [row for row in rows if row]
        cells = [what, next(filter(None, map(error, there)), ""), next((row["peer"] for row in there if "peer" in row), "")]
        for row in rows:
            row = row or {}
            cells += [time(row), number(row.get("ratio_peer"), ",.3g"), number(row.get("ratio_roofline"), ".2f")]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"
