# SPDX-License-Identifier: MIT OR Apache-2.0
"""Measures an exported page beside `overlook render` and the truth, at the viewpoints of a transforms.json with true pictures.

    pip install numpy pillow OpenEXR
    overlook demo orrery --frames 2 --size 240x180 --out scene && overlook preprocess scene --out scene.ovl
    python3 page_against_render.py scene.ovl scene/novel/transforms.json --program target/release/overlook --out measured

The store is exported as a page and opened in a headless Chromium with software OpenGL, at each view's pose, lens and frame, in a window
of the true picture's size. OUT gets page/, render/ and truth/ as PNG, and scores.json. Prints PSNR in dB on sRGB values, as a mean over
the views: of the page and the program each against the truth, and of the page against the program; over all pixels, and over those
that the program showed a sample in (`sampled` in its EXR: what some camera saw). A pixel is black where no channel reaches 8 of 255.
Under `best shift` is by how many pixels the page would have to move to be most like the program's picture: 0,0 unless a pose is wrong.
Exits with 1 where a page is below the program by more than --seen or --all dB.
"""

import argparse
import base64
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np
import OpenEXR
from PIL import Image

# Channels below it, of 255, are black; and from it on are clearly not, as in tests/page.
BLACK, CLEARLY_LIT = 8, 26
# Seconds after which a picture will not come any more.
PATIENCE = 300
SHIFTS = [(x, y) for y in range(-2, 3) for x in range(-2, 3)]


class Browser:
    """A window of a headless Chromium, driven over a pair of pipes by its own protocol."""

    def __init__(self, program):
        self.profile = tempfile.mkdtemp()
        commands_out, self.commands = os.pipe()
        self.messages, messages_in = os.pipe()
        # The shell opens the pipes as the descriptors 3 and 4, which the browser expects.
        shell = f'exec "$@" 3<&{commands_out} 4>&{messages_in}'
        flags = ["--headless=new", "--no-sandbox", "--no-first-run", "--hide-scrollbars", "--remote-debugging-pipe"]
        flags += ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking"]
        self.child = subprocess.Popen(
            ["bash", "-c", shell, "bash", program, *flags, f"--user-data-dir={self.profile}/profile", "about:blank"],
            pass_fds=(commands_out, messages_in), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        os.close(commands_out)
        os.close(messages_in)
        self.waiting, self.last, self.session, self.problems = b"", 0, None, []
        page = next(one for one in self.call("Target.getTargets")["targetInfos"] if one["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")

    def close(self):
        self.child.kill()
        self.child.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    def answer(self):
        while b"\0" not in self.waiting:
            piece = os.read(self.messages, 1 << 20)
            if not piece:
                raise SystemExit("the browser ended")
            self.waiting += piece
        message, self.waiting = self.waiting.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **parameters):
        self.last += 1
        message = {"id": self.last, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.commands, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.answer()
            if answer.get("id") == self.last:
                if "error" in answer:
                    raise SystemExit(f"{method}: {answer['error']}")
                return answer["result"]
            if answer.get("method") in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"):
                self.problems.append(json.dumps(answer["params"])[:300])

    def value(self, expression):
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in found:
            raise SystemExit(f"{expression}: {found['exceptionDetails']}")
        return found["result"].get("value")

    def picture(self, page, fragment, size):
        """What a page shows at rest, and what it says of it."""
        self.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False)
        # Another document, even where the address differs by its fragment alone.
        self.call("Page.navigate", url="about:blank")
        self.call("Page.navigate", url=page.absolute().as_uri() + fragment)
        start = time.monotonic()
        is_there = "Boolean(document.documentElement?.dataset.loaded && !overlook.isAwake && overlook.drawn?.isFinal)"
        while not self.value(is_there):
            if time.monotonic() - start > PATIENCE:
                raise SystemExit(f"no picture came of {fragment}: {self.problems}")
            time.sleep(0.05)
        told = self.value("({ ...document.documentElement.dataset })")
        png = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")), told | {"seconds": time.monotonic() - start}


def quaternion(turn):
    """x, y, z, w of a rotation."""
    trace = np.trace(turn)
    signs = [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
    squares = [1 + 2 * turn[axis, axis] - trace for axis in range(3)] + [1 + trace]
    largest = int(np.argmax(squares))
    if largest == 3:
        parts = [*signs, squares[3]]
    else:
        parts = [turn[axis, largest] + turn[largest, axis] for axis in range(3)] + [signs[largest]]
        parts[largest] = squares[largest]
    return np.array(parts) / np.linalg.norm(parts)


def address(view):
    """The fragment that shows a view: poses have y up and look along -z in the file, y down and along z in an address."""
    pose = np.array(view["transform_matrix"], np.float64)
    turn = quaternion(pose[:3, :3] @ np.diag([1.0, -1.0, -1.0]))
    lens = [view[key] for key in ("w", "h", "fl_x", "fl_y", "cx", "cy")]
    numbers = ",".join(repr(float(part)) for part in [*pose[:3, 3], *turn, 1])
    return f"#view={numbers}&frame={view['time']:g}&lens={','.join(repr(float(part)) for part in lens)}&bare"


def srgb(linear):
    linear = np.clip(np.nan_to_num(linear.astype(np.float64)), 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def channels(path):
    with OpenEXR.File(str(path)) as file:
        return {name: channel.pixels for name, channel in file.channels().items()}


def psnr(first, second, where):
    error = np.square(first - second)[where]
    return float(min(-10 * np.log10(max(error.mean(), 1e-12)), 120)) if error.size else float("nan")


def best_shift(picture, other):
    height, width = other.shape[:2]
    inner = np.s_[2:height - 2, 2:width - 2]
    moved = lambda x, y: np.roll(picture, (y, x), (0, 1))[inner]
    return min(SHIFTS, key=lambda shift: np.square(moved(*shift) - other[inner]).mean())


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}\n{done.stdout}{done.stderr}")
    return done.stdout


def save(path, picture):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.round(255 * picture).astype(np.uint8)).save(path)


def measure(view, page, program, truth, seen):
    everywhere = np.ones_like(seen)
    pairs = {"page": (page, truth), "render": (program, truth), "page~render": (page, program)}
    scores = {f"{name} {where}": psnr(*pair, mask) for name, pair in pairs.items()
              for where, mask in (("seen", seen), ("all", everywhere))}
    brightest = [np.round(255 * picture).max(-1) for picture in (page, program)]
    black = brightest[0] < BLACK
    return {
        "view": view["file_path"], **scores, "seen share": float(seen.mean()),
        "black": int((black & (brightest[1] >= BLACK)).sum()),
        "black beside lit": int((black & (brightest[1] >= CLEARLY_LIT)).sum()),
        "brightness": 255 * float((page - truth).mean()), "render brightness": 255 * float((program - truth).mean()),
        "best shift": best_shift(page, program), "mirror": psnr(page[:, ::-1], program, everywhere),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("store", type=pathlib.Path)
    parser.add_argument("views", type=pathlib.Path)
    parser.add_argument("--program", default="overlook")
    parser.add_argument("--browser", default="chromium")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--at-most", type=int, default=9, help="views")
    parser.add_argument("--seen", type=float, default=1.0, help="dB that the page may be below the program on what was seen")
    parser.add_argument("--all", type=float, default=1.5, help="dB that it may be below over all pixels")
    arguments = parser.parse_args()
    out = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    page = out / "scene.html"
    run(arguments.program, "export", "page", arguments.store, "--out", page)
    run(arguments.program, "render", arguments.store, "--views", arguments.views, "--out", out / "render", "--backend", "cpu")
    views = json.loads(arguments.views.read_text())["frames"][: arguments.at_most]
    browser, rows = Browser(arguments.browser), []
    try:
        for view in views:
            size = (int(view["w"]), int(view["h"]))
            name = pathlib.Path(view["file_path"]).with_suffix(".png")
            shown, told = browser.picture(page, address(view), size)
            if told["state"] != "ready" or told["size"] != f"{size[0]}×{size[1]}" or float(told["frame"]) != view["time"]:
                sys.exit(f"{name}: the page shows {told}")
            shown = shown / 255
            program = np.asarray(Image.open(out / "render" / name).convert("RGB")) / 255
            found = channels(arguments.views.parent / view["file_path"])
            linear = found["RGB"] if "RGB" in found else found["RGBA"][..., :3]
            seen = channels((out / "render" / name).with_suffix(".exr"))["sampled.V"] > 0
            row = measure(view, shown, program, srgb(linear), seen) | {"seconds": told["seconds"]}
            rows.append(row)
            save(out / "page" / name, shown)
            save(out / "truth" / name, srgb(linear))
            print(" ".join(f"{key} {value:.2f}" if isinstance(value, float) else f"{key} {value}" for key, value in row.items()), flush=True)
    finally:
        browser.close()
    mean = {key: float(np.mean([row[key] for row in rows])) for key, value in rows[0].items() if isinstance(value, (int, float))}
    (out / "scores.json").write_text(json.dumps({"mean": mean, "views": rows}, indent=1))
    print("mean:", " ".join(f"{key} {value:.2f}" for key, value in mean.items()))
    for problem in browser.problems:
        print("the browser says:", problem)
    below = {where: mean[f"render {where}"] - mean[f"page {where}"] for where in ("seen", "all")}
    is_wrong = below["seen"] > arguments.seen or below["all"] > arguments.all
    print(f"{'WRONG' if is_wrong else 'ok'}: the page is below the program by {below['seen']:.2f} dB seen, {below['all']:.2f} dB over all")
    sys.exit(1 if is_wrong else 0)


if __name__ == "__main__":
    main()
