//! The Python module under pytest, on the library that was built with this test, laid out as a wheel lays it out.

use std::path::{Path, PathBuf};
use std::process::Command;

#[path = "../../tests/common/skip.rs"]
mod skip;

/// The folder that tests and the libraries they need are built into; programs are in the one above.
fn built() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
}

/// A folder with the package `overlook` as it is installed: the sources beside this test, and the library.
fn installed(folder: &Path) {
    let package = folder.join("overlook");
    std::fs::create_dir_all(&package).unwrap();
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("overlook");
    for entry in std::fs::read_dir(sources).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, package.join(path.file_name().unwrap())).unwrap();
        }
    }
    let (library, name) = match std::env::consts::OS {
        "windows" => ("_engine.dll", "_engine.pyd"),
        "macos" => ("lib_engine.dylib", "_engine.abi3.so"),
        _ => ("lib_engine.so", "_engine.abi3.so"),
    };
    std::fs::copy(built().join(library), package.join(name)).unwrap();
}

#[test]
fn the_module_agrees_with_the_command_line_under_pytest() {
    let required = Some("OVERLOOK_REQUIRE_PYTHON");
    let python = std::env::var("OVERLOOK_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let found = Command::new(&python).args(["-c", "import numpy, pytest, OpenEXR"]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        skip::skip(
            required,
            &format!("{python} has no numpy, pytest and OpenEXR; OVERLOOK_PYTHON names one"),
        );
        return;
    }
    let program = built().join("..").join(format!("overlook{}", std::env::consts::EXE_SUFFIX));
    if !program.is_file() {
        skip::skip(
            required,
            "the program that the module is compared with is not built; cargo test --workspace does",
        );
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("installed");
    installed(&folder);
    let output = Command::new(&python)
        .args(["-m", "pytest", "--quiet", "-p", "no:cacheprovider"])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests"))
        // Python looks in the current folder first, where the sources lie without the library.
        .current_dir(&folder)
        .env("PYTHONPATH", &folder)
        .env("OVERLOOK", &program)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
}
