"""Table of the scoreboard, as text or Markdown."""

COLUMNS = [
    "scene", "renderer", "threads", "samples", "CPU s", "whole CPU s", "M samples/CPU s",
    "relative variance", "variance x CPU s", "ratio", "same lens", "mean",
]  # fmt: skip


def text(answer, markdown):
    """Returns the table, what is missing, and the problems."""
    table = cells(answer["results"])
    lines = markdown_table(table) if markdown else plain_table(table)
    machine = answer["machine"]
    lines.append("")
    lines.append(
        f"{machine['cpu']}, {machine['cores']} cores, load average {machine['load']:.1f} at the start;"
        f" medians of {answer['repeat']} runs."
    )
    lines.append("; ".join(dict.fromkeys(answer["versions"].values())) + ".")
    lines += [f"{name}: not measured, missing." for name in answer["missing"]]
    for name, lacking in answer["left_out"].items():
        lines.append(f"{name}: not for {', '.join(lacking)}; it has no lenses of several elements.")
    for r in answer["results"]:
        if r["too_short"]:
            lines.append(
                f"{r['scene']}, {r['renderer']}, threads {r['threads']}: {r['spp']} samples take too"
                " little time for an exact measurement; take more with --spp."
            )
    if answer["problems"]:
        bar = "!" * 78
        lines += ["", bar, *(f"DISAGREEMENT OR FAILURE: {p}" for p in answer["problems"]), bar]
    return "\n".join(lines)


def cells(results):
    """Returns the rows of the table, as text."""
    costs = {(r["scene"], r["threads"], r["renderer"]): r["cost"] for r in results}

    def ratio(r, renderer):
        cost = costs.get((r["scene"], r["threads"], renderer))
        return f"{r['cost'] / cost:.2f}" if cost else "-"

    table = []
    for r in results:
        mean = "-"
        if "mean_difference" in r:
            mean = f"{100 * r['mean_difference']:+.2f} ± {100 * r['mean_error']:.2f} %"
        table.append(
            [
                r["scene"], r["renderer"], str(r["threads"]), str(r["spp"]),
                f"{r['render_cpu']:.2f}", f"{r['whole_cpu']:.2f}",
                f"{r['samples_per_cpu_second'] / 1e6:.3f}", f"{r['relative_variance']:.3g}",
                f"{r['cost']:.3g}",
                ratio(r, "petzval"), ratio(r, r.get("compared_with")), mean,
            ]  # fmt: skip
        )
    return table


def plain_table(table):
    widths = [max(len(row[i]) for row in [COLUMNS, *table]) for i in range(len(COLUMNS))]
    return ["  ".join(c.ljust(w) for c, w in zip(row, widths)).rstrip() for row in [COLUMNS, *table]]


def markdown_table(table):
    rule = ["---", "---"] + ["--:"] * (len(COLUMNS) - 2)
    return ["| " + " | ".join(row) + " |" for row in [COLUMNS, rule, *table]]
