"""Reads what `overlook export splats` writes with programs that are not ours, and compares what they find.

    pip install usd-core plyfile spz numpy
    npm install @playcanvas/splat-transform gltf-validator
    overlook demo orrery --out scene && overlook preprocess scene --out scene.ovl --set store.normals=true
    python3 assets/splats/check.py scene.ovl --program target/release/overlook --modules FOLDER_WITH_NODE_MODULES

Every program must read its file without a complaint, and find the same splats: as many, and in the same places, of the same size, turned
alike, in the same colors. The store holds normals: estimated ones depend on what else a file holds. Exits with 1 and says what is wrong otherwise.
"""

import argparse
import importlib.util
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from plyfile import PlyData
from pxr import Usd, UsdGeom, UsdValidation, UsdVol

FAILED = []


def check(is_right, what):
    print(("ok      " if is_right else "WRONG   ") + what)
    if not is_right:
        FAILED.append(what)


def export(program, store, out, *arguments):
    done = subprocess.run(
        [program, "export", "splats", store, "--format", out.suffix[1:], "--out", out, *arguments],
        capture_output=True, text=True,
    )
    print(done.stdout.strip() or done.stderr.strip())
    if done.returncode != 0:
        sys.exit(1)


def spz_module():
    """The compiled part of the package, whose own first file of version 0.0.1 imports itself."""
    package = pathlib.Path(importlib.util.find_spec("spz").submodule_search_locations[0])
    spec = importlib.util.spec_from_file_location("spz", next(package.glob("spz.*.so")))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def covariances(rotations, radii):
    """Of quaternions w, x, y, z and standard deviations: unlike these, they have no order and no sign."""
    w, x, y, z = (rotations / np.linalg.norm(rotations, axis=1, keepdims=True)).T
    axes = np.stack([
        np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
        np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
        np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1),
    ], 1)
    return np.einsum("nij,nj,nkj->nik", axes, radii**2, axes)


def of_ply(path):
    vertex = PlyData.read(path)["vertex"]
    columns = lambda *names: np.stack([np.asarray(vertex[name], np.float64) for name in names], -1)
    return {
        "centers": columns("x", "y", "z"),
        "covariances": covariances(
            columns("rot_0", "rot_1", "rot_2", "rot_3"), np.exp(columns("scale_0", "scale_1", "scale_2"))
        ),
        "colors": columns("f_dc_0", "f_dc_1", "f_dc_2"),
        "opacities": 1 / (1 + np.exp(-np.asarray(vertex["opacity"], np.float64))),
    }


def turned(splats, matrix):
    """Splats in other axes."""
    return splats | {
        "centers": splats["centers"] @ matrix.T,
        "covariances": matrix @ splats["covariances"] @ matrix.T,
    }


def compare(name, found, expected, place, size, color):
    """Largest differences: of places in units, of covariances as a share, of coefficients."""
    count = len(expected["centers"])
    check(len(found["centers"]) == count, f"{name}: {len(found['centers'])} of {count} splats")
    if len(found["centers"]) != count:
        return
    off = np.abs(found["centers"] - expected["centers"]).max()
    check(off <= place, f"{name}: places within {off:.2g}")
    scale = np.linalg.norm(expected["covariances"], axis=(1, 2))
    off = (np.linalg.norm(found["covariances"] - expected["covariances"], axis=(1, 2)) / scale).max()
    check(off <= size, f"{name}: covariances within {100 * off:.2g} %")
    off = np.abs(found["colors"] - expected["colors"]).max()
    check(off <= color, f"{name}: coefficients of color within {off:.2g}")
    off = np.abs(found["opacities"] - expected["opacities"]).max()
    check(off < 0.01, f"{name}: opacities within {off:.2g}")


# y down and z forward to y up and z back, and the other way round.
FLIP = np.diag([1.0, -1.0, -1.0])


def check_spz(path, expected, place):
    module = spz_module()
    read = module.GaussianSplat.load(str(path))
    count = read.num_points
    shaped = lambda values, width: np.asarray(values, np.float64).reshape(count, width)
    rotations = shaped(read.rotations, 4)[:, [3, 0, 1, 2]]
    found = {
        "centers": shaped(read.positions, 3),
        "covariances": covariances(rotations, np.exp(shaped(read.scales, 3))),
        "colors": shaped(read.colors, 3),
        "opacities": 1 / (1 + np.exp(-np.asarray(read.alphas, np.float64))),
    }
    compare("spz (pypi)", found, turned(expected, FLIP), place, 0.15, 0.04)


def check_usd(path, frames, seen_at):
    stage = Usd.Stage.Open(str(path))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    # A package has to be of one file alone; this is none.
    of_files = [one for one in validators if "Package" not in one.GetMetadata().name]
    complaints = [error.GetMessage() for error in UsdValidation.ValidationContext(of_files).Validate(stage)]
    check(not complaints, f"usd-core: {len(complaints)} complaints {complaints[:3]}")
    check(UsdGeom.GetStageUpAxis(stage) == "Y", "usd-core: y is up")
    prims = [prim for prim in stage.Traverse() if prim.GetTypeName() == "ParticleField3DGaussianSplat"]
    check(all(prim.IsA(UsdVol.ParticleField3DGaussianSplat) for prim in prims), f"usd-core: {len(prims)} particle fields")
    names = ["positions", "orientations", "scales", "opacities", "radiance:sphericalHarmonicsCoefficients"]
    for prim in prims:
        lengths = {len(prim.GetAttribute(name).Get()) for name in names}
        if len(lengths) != 1:
            check(False, f"usd-core: {prim.GetName()} has arrays of {lengths}")
        definition = prim.GetPrimDefinition()
        for attribute in prim.GetAuthoredAttributes():
            known = definition.GetAttributeDefinition(attribute.GetName())
            is_right = known and known.GetTypeName() == attribute.GetTypeName()
            if not is_right or known.GetVariability() != attribute.GetVariability():
                check(False, f"usd-core: {attribute.GetName()} is {attribute.GetTypeName()}, {attribute.GetVariability()}")
    for frame in range(frames):
        visible = [prim for prim in prims if UsdGeom.Imageable(prim).ComputeVisibility(frame) != "invisible"]
        count = sum(len(prim.GetAttribute("positions").Get()) for prim in visible)
        check(count == seen_at(frame), f"usd-core: {count} splats at time code {frame}")
    return stage


def usd_at(stage, frame):
    parts = []
    for prim in stage.Traverse():
        if prim.GetTypeName() != "ParticleField3DGaussianSplat":
            continue
        if UsdGeom.Imageable(prim).ComputeVisibility(frame) == "invisible":
            continue
        get = lambda name: prim.GetAttribute(name).Get()
        rotations = np.array([[q.GetReal(), *q.GetImaginary()] for q in get("orientations")], np.float64)
        parts.append({
            "centers": np.array(get("positions"), np.float64),
            "covariances": covariances(rotations, np.array(get("scales"), np.float64)),
            "colors": np.array(get("radiance:sphericalHarmonicsCoefficients"), np.float64),
            "opacities": np.array(get("opacities"), np.float64),
        })
    return {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}


def by_place(splats):
    # By x first: backs of surfaces are placed in single precision in the axes of the file, and differ in the last bit of z.
    order = np.lexsort(splats["centers"].T[::-1] + 0.0)
    return {key: values[order] for key, values in splats.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("store")
    parser.add_argument("--program", default="overlook")
    parser.add_argument("--modules", required=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        run(arguments, pathlib.Path(folder))
    print(f"{len(FAILED)} wrong")
    sys.exit(1 if FAILED else 0)


def run(arguments, folder):
    program, store = arguments.program, arguments.store
    export(program, store, folder / "scene.glb")
    export(program, store, folder / "scene.usda")
    frames = folder / "frames.ply"
    export(program, store, frames)
    plys = [of_ply(path) for path in sorted(frames.glob("*.ply"))]
    first = sorted(frames.glob("*.ply"))[0]
    (folder / "scene.ply").write_bytes(first.read_bytes())
    export(program, store, folder / "scene.spz", "--frame", str(int(first.stem)))
    expected = plys[0]
    check(len(expected["centers"]) > 0, f"plyfile: {len(expected['centers'])} splats in the first of {len(plys)} frames")
    extent = np.abs(expected["centers"]).max()
    check_spz(folder / "scene.spz", expected, extent / 2**21)
    stage = check_usd(folder / "scene.usda", len(plys), lambda frame: len(plys[frame]["centers"]))
    found = turned(usd_at(stage, 0), FLIP)
    compare("usd-core at 0", by_place(found), by_place(expected), extent / 2**23, 1e-3, 1e-5)
    # A whole scene has one sky, that of its first frame.
    last = len(plys) - 1
    export(program, store, folder / "last.usda", "--sky", "out")
    export(program, store, folder / "last.ply", "--sky", "out", "--frame", str(int(sorted(frames.glob("*.ply"))[last].stem)))
    found = turned(usd_at(Usd.Stage.Open(str(folder / "last.usda")), last), FLIP)
    compare(f"usd-core at {last}", by_place(found), by_place(of_ply(folder / "last.ply")), extent / 2**23, 1e-3, 1e-5)
    script = pathlib.Path(__file__).with_name("check.mjs")
    told = json.loads(subprocess.check_output(["node", script, arguments.modules, folder], text=True))
    issues = told["glb"]["issues"]
    # Of the ratified extension this validator knows not even the names of its attributes; it refuses other programs' files alike.
    unknown = "/attributes/KHR_gaussian_splatting:"
    loud = [issue for issue in issues["messages"] if issue["severity"] < 2 and unknown not in issue["pointer"]]
    check(not loud, f"gltf-validator: {len(loud)} errors and warnings besides names that it does not know {loud[:3]}")
    codes = sorted({(issue["code"], issue["message"]) for issue in issues["messages"]})
    print("        it notes:", codes[:6])
    for name, place, size, color in [("ply", 1e-5, 1e-3, 1e-4), ("spz", extent / 2**21, 0.15, 0.04)]:
        print("        splat-transform:", " ".join(told[name]["told"].split())[:200])
        compare(f"splat-transform ({name})", of_ply(told[name]["out"]), expected, place, size, color)


if __name__ == "__main__":
    main()
