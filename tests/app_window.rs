//! The program itself in a real window, on a display of the test's own: clicked, typed at, looked at, and closed.
//!
//! Needs Xvfb and xdotool; where they are missing the test says so and checks nothing.
#![cfg(target_os = "linux")]

use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Ends its process when the test does, however it does.
struct Guard(Child);

impl Drop for Guard {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn has(program: &str) -> bool {
    Command::new("which").arg(program).stdout(Stdio::null()).status().is_ok_and(|status| status.success())
}

/// Starts Xvfb on a display that it picks itself and tells on its standard output.
fn start_display() -> (Guard, String) {
    let mut server = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut output = server.stdout.take().unwrap();
    let guard = Guard(server);
    let mut number = Vec::new();
    let mut byte = [0];
    while output.read(&mut byte).unwrap() == 1 && byte[0] != b'\n' {
        number.push(byte[0]);
    }
    (guard, format!(":{}", String::from_utf8(number).unwrap().trim()))
}

fn xdotool(display: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new("xdotool").args(arguments).env("DISPLAY", display).output().unwrap();
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn wait_for<T>(what: &str, mut attempt: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(found) = attempt() {
            return found;
        }
        assert!(started.elapsed() < Duration::from_secs(60), "waited too long for {what}");
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// Different colors on the display, as the X server itself gives its pixels.
fn colors_on(display: &str, folder: &Path) -> usize {
    let shot = folder.join("shot.png");
    let taken = Command::new("import").args(["-window", "root"]).arg(&shot).env("DISPLAY", display).status();
    assert!(taken.unwrap().success());
    let picture = image::open(&shot).unwrap().to_rgb8();
    picture.pixels().map(|pixel| pixel.0).collect::<std::collections::HashSet<_>>().len()
}

#[test]
fn the_program_opens_a_window_that_answers_and_closes() {
    for program in ["Xvfb", "xdotool", "import"] {
        if !has(program) {
            println!("SKIPPED: {program} is not installed, so no real window was opened");
            return;
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let (_server, display) = start_display();
    let program = Command::new(env!("CARGO_BIN_EXE_overlook"))
        .env("DISPLAY", &display)
        .env_remove("WAYLAND_DISPLAY")
        .env("XDG_DATA_HOME", folder.path())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut program = Guard(program);
    let id =
        wait_for("the window", || xdotool(&display, &["search", "--onlyvisible", "--name", "^Overlook$"]));
    let id = id.lines().next().unwrap().to_owned();
    // Without a window manager nothing gives the window the keyboard.
    wait_for("the keyboard", || xdotool(&display, &["windowfocus", "--sync", &id]));
    wait_for("the first picture", || (colors_on(&display, folder.path()) > 2000).then_some(()));
    for keys in ["period", "period", "comma", "2", "space", "space", "w"] {
        xdotool(&display, &["key", keys]).unwrap();
    }
    // The theme switch at the right end of the top bar, then a drag in the live view.
    xdotool(&display, &["mousemove", "1252", "22", "click", "1"]).unwrap();
    xdotool(&display, &["mousemove", "700", "400", "mousedown", "1"]).unwrap();
    xdotool(&display, &["mousemove_relative", "--sync", "80", "10", "mouseup", "1"]).unwrap();
    std::thread::sleep(Duration::from_millis(500));
    assert!(program.0.try_wait().unwrap().is_none(), "the program is still there");
    assert!(colors_on(&display, folder.path()) > 2000, "the window still shows pictures");
    xdotool(&display, &["key", "ctrl+q"]).unwrap();
    let status = wait_for("the program to end", || program.0.try_wait().unwrap());
    assert!(status.success(), "{status}");
}
