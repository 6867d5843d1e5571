"""RESULTS.md, and the headline of README.md, made of what results.json holds."""
import math
import re

COMMAND = "assets/results/make.py target/release/overlook"
# Behind the name of a capture that another program measured.
MARK = "†"

MARKS = ("<!-- Written by assets/results/make.py from here … -->", "<!-- … to here. -->")


def decibels(squared_error):
    """PSNR of a mean squared error of values from 0 to 1; 99 dB for none, as the program says it."""
    return min(-10 * math.log10(squared_error), 99.0) if squared_error > 0 else 99.0


def results_page(results):
    """The whole of RESULTS.md."""
    captures = results["captures"]
    present = [entry for entry in captures if is_present(results, entry)]
    return "\n".join([
        "# Results",
        "",
        "Overlook takes scenes that several cameras recorded as color and depth, drops every pixel that another one represents as well, and shows",
        f"what is left from new viewpoints. {results['program'].capitalize()} on {counted(present)}, each figure from its smallest to its largest:",
        "",
        *figures(results),
        "",
        *headline_table(results),
        "",
        "*Kept*: samples beside recorded pixels. *Picture*: the time of one, of the capture's own size. *dB*: over surfaces / over all that some camera",
        "saw, at viewpoints without a camera. *Ahead of*: by how many dB, ± standard error over viewpoints.",
        "",
        *older(results),
        "## Where it loses",
        "",
        *[f"- {sentence}" for sentence in losses(present or captures)],
        "",
        "![Accuracy against bytes and against milliseconds](assets/results/pareto.png)",
        "",
        f"*`orrery`: every method, ours with four kernels. Up and to the left is better.*{mark_of_chart(results)}",
        "",
        *size_section(results),
        "## All figures",
        "",
        *words(),
        "",
        *method_table(results),
        "",
        "## What each switch of the renderer gives, and what it takes",
        "",
        "Each is changed by itself. *dB*: PSNR over all pixels, holes among them, against the default's; from the least to the most of all captures.",
        "*Time*: of a picture, as a multiple of the default's. Each switch is measured at the pictures that it is for.",
        "",
        *switch_table(present or captures),
        "",
        "## To repeat it",
        "",
        *repetition(results),
    ]) + "\n"


def is_present(results, entry):
    """Whether the program that the page is of makes the pictures of the one that measured a capture."""
    return entry["accuracy"]["pictures"] == results["pictures"]


def is_timed(results, entry):
    return entry.get("times", {}).get("pictures") == results["pictures"]


def figures(results, link=""):
    """The three figures that matter, one line each, of the captures that this program measured."""
    captures = [entry for entry in results["captures"] if is_present(results, entry)]
    timed = [entry for entry in captures if is_timed(results, entry)]
    linked = lambda text: f"[{text}]({link})" if link else text
    if not captures:
        yield f"- {linked('All figures')} were measured by another program, whose pictures differ."
        return
    dropped = [100 * (1 - ours(entry)["kept"]) for entry in captures]
    yield (
        f"- **Size:** {linked(f'{span(dropped)} % of the pixels')} of {counted(captures)} are dropped. The rest takes {span(shares(captures))} % of the raw bytes in a store."
    )
    yield (
        f"- **Accuracy:** {linked(against(captures, 'everything'))} against keeping all pixels, {against(captures, 'rival')} against the best rival, "
        f"{against(captures, 'paper')} against the paper's own way (PSNR at new viewpoints)."
    )
    if timed:
        threads, painters = [listed(sorted({str(entry["times"][key]) for entry in timed})) for key in ("threads", "painted_by")]
        where = f"{threads} threads of the CPU" if painters == "cpu" else f"{painters} and {threads} threads"
        took = span(milliseconds(entry, "ours") for entry in timed)
        yield (
            f"- **Time:** a picture takes {linked(f'{took} ms')} on {where}, preparing a capture "
            f"{span(entry['times']['seconds_preprocess'] for entry in timed)} s."
        )


def counted(captures):
    return f"{len(captures)} capture{'' if len(captures) == 1 else 's'}"


def mark_of_chart(results):
    """The mark of the chart, which is drawn when its capture is timed."""
    is_old = any("rival" in entry.get("times", {}).get("milliseconds", {}) and not is_timed(results, entry) for entry in results["captures"])
    return f" {MARK}" if is_old else ""


def milliseconds(entry, role):
    """The median time of a picture by a method; None where it was not timed."""
    return entry.get("times", {}).get("milliseconds", {}).get(role)


def older(results):
    """What the mark of a row means, where one has it."""
    if all(is_present(results, entry) and is_timed(results, entry) for entry in results["captures"]):
        return
    yield f"{MARK} Measured by another program, which makes other pictures of `small_capture` than this one. The figures above leave such rows and such times out."
    yield ""


def named(results, entry):
    """The name of a capture, marked where another program measured it."""
    mark = "" if is_present(results, entry) else f" {MARK}"
    return f"`{entry['name']}`{mark}, {shape(entry)}"


def size_section(results):
    """The time of pictures by their size."""
    timed = results.get("sizes")
    if not timed:
        return
    mark = "" if timed["pictures"] == results["pictures"] else f" {MARK}"
    kernels = list(timed["rows"][0]["milliseconds"])
    yield f"## Time by size{mark}"
    yield ""
    yield f"The scene of `orrery`, seen at the size at which five cameras recorded it, 6 frames. Commit `{timed['commit']}`, {timed['date']}."
    yield ""
    yield "| size | preparing, s | " + " | ".join(f"`{kernel}`, ms" for kernel in kernels) + " |"
    yield "|---|---|" + "---|" * len(kernels)
    for row in timed["rows"]:
        cells = [row["size"], rounded(row["seconds_preprocess"])] + [rounded(row["milliseconds"][kernel]) for kernel in kernels]
        yield "| " + " | ".join(cells) + " |"
    yield ""


def shares(captures):
    return [100 * ours(entry)["bytes"] / entry["bytes_raw"] for entry in captures]


def ours(entry):
    return entry["methods"]["ours"]


def span(values):
    """The smallest and the largest of some values, in words."""
    low, high = (rounded(value) for value in extremes(values))
    return low if low == high else f"{low} to {high}"


def rounded(value):
    """To two or three digits, never in powers of ten."""
    return f"{value:.0f}" if value >= 9.95 else f"{value:.1f}" if value >= 1 else f"{value:.2g}"


def extremes(values):
    values = list(values)
    return min(values), max(values)


def against(captures, role):
    """How ours compares with a method over all captures, as in '−0.2 to +0.4 dB'."""
    low, high = (signed(value) for value in extremes(entry["methods"][role]["ours_ahead_db"] for entry in captures))
    return f"{low} to {high} dB" if low != high else f"{low} dB"


def signed(decibel, digits=1):
    text = f"{decibel:+.{digits}f}"
    return text.replace("-", "−") if float(text) else "0"


def headline_table(results):
    yield "| capture | kept | store, of raw | picture | dB | ahead of all pixels | ahead of the best rival | ahead of the paper | commit |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for entry in results["captures"]:
        one, methods = ours(entry), entry["methods"]
        cells = [
            named(results, entry),
            percent(one["kept"]),
            f"{size(one['bytes'])}, {percent(one['bytes'] / entry['bytes_raw'])}",
            time_of(entry, "ours", " ms") + ("" if "times" not in entry or is_timed(results, entry) else f" {MARK}"),
            accuracy(one),
            ahead(methods["everything"]),
            ahead(methods["rival"]),
            ahead(methods["paper"]),
            f"`{entry['accuracy']['commit']}`",
        ]
        yield "| " + " | ".join(cells) + " |"


def time_of(entry, role, unit=""):
    took = milliseconds(entry, role)
    return "–" if took is None else f"{took:.0f}{unit}" if took >= 10 else f"{took:.1f}{unit}"


def shape(entry):
    sizes = entry["sizes"][0] if len(entry["sizes"]) == 1 else "several sizes"
    return f"{entry['cameras']} cameras × {entry['frames']} frames, {sizes}" if entry["frames"] > 1 else f"{entry['cameras']} views, {sizes}"


def percent(share):
    value = 100 * share
    return f"{value:.0f} %" if value >= 9.95 else f"{value:.1f} %"


def size(count):
    """Bytes as people read them."""
    return f"{count / 1e6:.3g} MB" if count >= 1e6 else f"{count / 1e3:.3g} kB"


def accuracy(method):
    surfaces = "–" if method["db_surfaces"] is None else f"{method['db_surfaces']:.2f}"
    return f"{surfaces} / {method['db_seen']:.2f}"


def ahead(method):
    return f"{signed(method['ours_ahead_db'], 2)} ± {method['ours_ahead_db_se']:.2f}"


def short_label(method):
    """The name of a method without the kernel of the default, which all but the paper's way and rivals with another one have."""
    return method["label"].removesuffix(", gather")


def losses(captures):
    """Where it loses, one sentence each: accuracy, the places of the error, and the costs."""
    yield lost_accuracy(captures)
    classes = [entry["error_by_class"] for entry in captures if entry["error_by_class"]]
    unseen = [one["unseen"]["psnr_db"] for one in classes if one["unseen"]["psnr_db"] is not None]
    edges = [one["edge"] for one in classes]
    yield (
        f"**Edges and holes.** Pixels within 2 px of a step in depth are {span(100 * edge['share'] for edge in edges)} % of those that show a surface, "
        f"and hold {span(100 * edge['of_error'] for edge in edges)} % of the squared error; surfaces that no camera saw are guessed, at {span(unseen)} dB."
    )
    slower = [milliseconds(entry, "ours") / milliseconds(entry, "paper") for entry in captures if "times" in entry]
    first = [entry["methods"]["first"] for entry in captures]
    fewer = [100 * method["bytes"] / ours(entry)["bytes"] for method, entry in zip(first, captures)]
    low, high = (signed(-value) for value in reversed(extremes(method["ours_ahead_db"] for method in first)))
    papers = [(entry["name"], entry["methods"]["paper"]["bytes"] / ours(entry)["bytes"]) for entry in captures]
    smaller = [f"{100 * share:.0f} % of ours on `{name}`" for name, share in papers if share < 0.995]
    yield (
        f"**Time and bytes.** {f'A picture takes {span(slower)} times as long as by' if slower else 'Times were not measured against'} the paper's way"
        f"{f', whose store is smaller at times ({listed(smaller)})' if smaller else ''}; *first camera wins* needs {span(fewer)} % of our bytes, "
        f"at {low if low == high else f'{low} to {high}'} dB."
    )


def lost_accuracy(captures):
    def behind(role):
        lost = [entry for entry in captures if entry["methods"][role]["ours_ahead_db"] < -0.005]
        told = [(entry["name"], entry["methods"][role]) for entry in lost]
        label = lambda method: f" (*{short_label(method)}*)" if role == "rival" else ""
        return [f"{-method['ours_ahead_db']:.2f} ± {method['ours_ahead_db_se']:.2f} dB on `{name}`{label(method)}" for name, method in told]

    everything, rivals = behind("everything"), behind("rival")
    if rivals:
        text = f"**Accuracy.** A rival is ahead by {listed(rivals)}"
    else:
        closest = min(captures, key=lambda entry: entry["methods"]["rival"]["ours_ahead_db"])
        rival = closest["methods"]["rival"]
        text = f"**Accuracy.** No rival is ahead, the closest is *{short_label(rival)}* on `{closest['name']}`, {rival['ours_ahead_db']:.2f} dB behind"
    if everything:
        return f"{text}; dropping pixels costs {listed(everything)}."
    return f"{text}; dropping pixels costs accuracy on no capture."


def listed(parts):
    return parts[0] if len(parts) == 1 else ", ".join(parts[:-1]) + " and " + parts[-1]


def words():
    yield "- *Ours*: the default settings. *All pixels*: the same, but cameras are not pruned against each other."
    yield "- *Best rival*: the most accurate of *first camera wins*, random samples and a voxel grid (with as many samples as ours), a triangle mesh per"
    yield "  camera, TSDF volumes of three sizes, the nearest camera and a layered depth image, each with the kernel that suits it best."
    yield "- *The paper's way*: two lengths of span, the sampling rate `r`, the 4-pixel kernel, and nothing that was added to it. Its samples lie in our"
    yield "  store."
    yield "- *dB*: PSNR of pictures whose truth is known, holes of all methods filled alike. *Surfaces*: all pixels that show a surface, of all pictures"
    yield "  together. *Seen*: all pixels of what some camera saw, sky among it, the mean over pictures; *ours ahead* is of these."
    yield "- *ms*: a picture from a store with everything that is on by default (antialiasing, free space, filling): the median of all true viewpoints,"
    yield "  each three times. The paper's way fills no holes. Rivals are timed on `orrery` alone."
    yield "- *Bytes*: the whole store, but for what became of the dropped pixels (`store.verdicts`), at most a tenth more. *Raw*: 8-bit color and"
    yield "  32-bit depth of every pixel."


ROLES = [("ours", "**ours**"), ("everything", "all pixels"), ("rival", "best rival: {}"), ("paper", "the paper's way")]


def method_table(results):
    yield "| capture | method | dB on surfaces | dB seen | ours ahead | bytes | of raw | ms | kept |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for entry in results["captures"]:
        mark = "" if is_present(results, entry) else f" {MARK}"
        for role, name in ROLES:
            method = entry["methods"][role]
            surfaces, seen = accuracy(method).split(" / ")
            cells = [
                f"`{entry['name']}`{mark}" if role == "ours" else "",
                name.format(short_label(method)),
                surfaces,
                seen,
                "" if role == "ours" else ahead(method),
                size(method["bytes"]),
                percent(method["bytes"] / entry["bytes_raw"]),
                time_of(entry, role),
                "all" if method["kept"] >= 1 else percent(method["kept"]),
            ]
            yield "| " + " | ".join(cells) + " |"


def switch_table(captures):
    yield "| switch | at | dB | time |"
    yield "|---|---|---|---|"
    rows = {(row["label"], row["store"], row["wide"]): None for entry in captures for row in entry["switches"]}
    for label, store, wide in rows:
        is_row = lambda row: (row["label"], row["store"], row["wide"]) == (label, store, wide)
        gains = [row["db"] - row["default_db"] for entry in captures for row in entry["switches"] if is_row(row)]
        times = [row["times_as_long"] for entry in captures for row in entry.get("times", {}).get("switches", []) if is_row(row)]
        least, most = signed(min(gains), 2), signed(max(gains), 2)
        fastest, slowest = (f"{min(times):.2f}", f"{max(times):.2f}") if times else ("–", "–")
        cells = [
            f"`{label.replace('=', ' = ')}`",
            pictures_of(store, wide, [entry["name"] for entry in captures if any(is_row(row) for row in entry["switches"])]),
            least if least == most else f"{least} to {most}",
            fastest if fastest == slowest else f"{fastest} to {slowest}",
        ]
        yield "| " + " | ".join(cells) + " |"


def pictures_of(store, wide, names):
    """Which pictures a switch is measured at, in words."""
    where = "stores that were not pruned" if store == "everything" else "all captures"
    if wide == 1:
        return where
    sizes = f"{wide:g} times as wide" if wide > 1 else f"{100 * wide:.0f} % as wide"
    return f"pictures {sizes} as recorded, of {listed([f'`{name}`' for name in names])}".replace("as wide as recorded", "as wide as recorded ones")


def repetition(results):
    captures = results["captures"]
    yield "One command measures the captures that are built in or in the repository, and further ones that are named behind it, and writes this page."
    yield "It takes some 40 minutes on two cores. `--accuracy` and `--times` measure a part each: times need a quiet machine, accuracy does not."
    yield ""
    yield f"```sh\n{COMMAND}     # and CAPTURE..., each with true pictures in novel/\n```"
    yield ""
    yield f"The default settings are `{results['settings_fingerprint']}`, and the pictures of `small_capture` have the checksum `{results['pictures']}`. A test fails once"
    yield "the program has others. `make.py --write-only PROGRAM` then marks the rows that another program measured. What is run for each capture:"
    yield ""
    for entry in captures:
        measured, timed = entry["accuracy"], entry.get("times")
        by = f" Times: `{timed['commit']}`, {timed['date']}, {timed['machine']}, {timed['threads']} threads." if timed else ""
        yield (
            f"- `{entry['name']}`: {entry['content']}, {entry['true_pictures']} true pictures from {entry['viewpoints']} viewpoints. Commit "
            f"`{measured['commit']}`, {measured['date']}.{by}"
        )
    yield ""
    yield "```sh"
    for entry in captures:
        if entry["recording"]:
            yield entry["recording"]
    yield f"overlook sweep CAPTURE {captures[0]['sweep'].split(' ', 3)[3].rsplit(' ', 1)[0]} CAPTURE-sweep"
    yield "overlook preprocess CAPTURE --out ours.ovl"
    yield "overlook preprocess CAPTURE --out all.ovl --set pruning.method=off"
    for line in sorted({entry["paper_settings"] for entry in captures}):
        yield from wrapped(f"overlook preprocess CAPTURE --out paper.ovl {line}")
    yield "overlook render ours.ovl --views CAPTURE/novel/transforms.json --out pictures         # three times, and so the other two"
    yield "overlook render ours.ovl --views CAPTURE/novel/transforms.json --out pictures --set render.free_space=false     # and each switch"
    yield "```"
    yield ""
    yield "[results.json](assets/results/results.json) has all figures, the [notebook](assets/results/notebook.md) what was learned of older programs,"
    yield "[SCALE.md](SCALE.md) how large captures may grow."


def wrapped(line, width=140):
    """A command over several lines."""
    while len(line) > width:
        cut = line.rindex(" --", 0, width)
        yield line[:cut] + " \\"
        line = "   " + line[cut:]
    yield line


def with_headline(readme, results):
    """README.md with its figures as measured."""
    block = "\n".join([MARKS[0], *figures(results, "RESULTS.md"), MARKS[1]])
    return re.sub(re.escape(MARKS[0]) + ".*?" + re.escape(MARKS[1]), lambda _: block, readme, flags=re.DOTALL)
