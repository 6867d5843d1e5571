//! A display of a test's own, and the program on it: clicked, typed at and looked at.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt, CreateWindowAux, WindowClass};

use super::skip::skip;

/// Ends its process when the test does, however it does.
pub(crate) struct Guard(pub(crate) Child);

impl Drop for Guard {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn has(program: &str) -> bool {
    Command::new("which").arg(program).stdout(Stdio::null()).status().is_ok_and(|status| status.success())
}

/// Starts Xvfb on a display that it picks itself and tells on its standard output. By itself it would start anew whenever its last
/// client leaves, and who comes at that moment is turned away.
pub(crate) fn start_display() -> (Guard, String) {
    let mut server = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset"])
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

pub(crate) fn xdotool(display: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new("xdotool").args(arguments).env("DISPLAY", display).output().unwrap();
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

pub(crate) fn wait_for<T>(what: &str, mut attempt: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(found) = attempt() {
            return found;
        }
        assert!(started.elapsed() < Duration::from_mins(2), "waited too long for {what}");
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// What is on the display, as the X server itself gives its pixels.
pub(crate) fn picture_of(display: &str, folder: &Path) -> image::DynamicImage {
    let shot = folder.join("shot.png");
    let taken = Command::new("import").args(["-window", "root"]).arg(&shot).env("DISPLAY", display).status();
    assert!(taken.unwrap().success());
    image::open(&shot).unwrap()
}

/// Different colors on the display.
pub(crate) fn colors_on(display: &str, folder: &Path) -> usize {
    let picture = picture_of(display, folder).to_rgb8();
    picture.pixels().map(|pixel| pixel.0).collect::<std::collections::HashSet<_>>().len()
}

/// Whether the programs are there that the tests need; says so where they are not.
pub(crate) fn can_drive_a_window() -> bool {
    let missing = ["Xvfb", "xdotool", "import"].into_iter().find(|program| !has(program));
    if let Some(program) = missing {
        let why = format!("no real window was opened: {program} is not installed");
        skip(Some("OVERLOOK_REQUIRE_WINDOW"), &why);
    }
    missing.is_none()
}

/// The program on a display of its own, with the keyboard.
pub(crate) fn start_program(display: &str, folder: &Path, arguments: &[&Path]) -> Guard {
    let said = folder.join("said.txt");
    let program = Command::new(env!("CARGO_BIN_EXE_overlook"))
        .args(arguments)
        // A path that is typed in part lies with the rest of the test.
        .current_dir(folder)
        .env("DISPLAY", display)
        .env_remove("WAYLAND_DISPLAY")
        .env("XDG_DATA_HOME", folder)
        // No dialog of somebody's desktop: the window's own path field takes over.
        .env("DBUS_SESSION_BUS_ADDRESS", "unix:path=/nonexistent")
        .env("PATH", folder)
        .stderr(File::create(&said).unwrap())
        .spawn()
        .unwrap();
    let mut program = Guard(program);
    let id = wait_for("the window", || {
        let ended = program.0.try_wait().unwrap();
        let said = || std::fs::read_to_string(&said).unwrap();
        assert!(ended.is_none(), "the program ended before it had a window, {ended:?}: {}", said());
        xdotool(display, &["search", "--onlyvisible", "--name", "^Overlook$"])
    });
    let id = id.lines().next().unwrap().to_owned();
    // Without a window manager nothing gives the window the keyboard.
    wait_for("the keyboard", || xdotool(display, &["windowfocus", "--sync", &id]));
    program
}

pub(crate) fn wait_for_pictures(display: &str, folder: &Path) {
    wait_for("the first picture", || (colors_on(display, folder) > 2000).then_some(()));
}

pub(crate) fn quit(display: &str, mut program: Guard) {
    xdotool(display, &["key", "ctrl+q"]).unwrap();
    let status = wait_for("the program to end", || program.0.try_wait().unwrap());
    assert!(status.success(), "{status}");
}

/// The text on the display's clipboard, where its owner gives one.
pub(crate) fn clipboard_text(display: &str) -> Option<String> {
    let (connection, screen) = x11rb::connect(Some(display)).unwrap();
    let root = connection.setup().roots[screen].root;
    let window = connection.generate_id().unwrap();
    let area = CreateWindowAux::new();
    connection.create_window(0, window, root, 0, 0, 1, 1, 0, WindowClass::INPUT_ONLY, 0, &area).unwrap();
    let atom = |name: &str| connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
    let [clipboard, text, kept] = ["CLIPBOARD", "UTF8_STRING", "OVERLOOK_TEST"].map(atom);
    connection.convert_selection(window, clipboard, text, kept, x11rb::CURRENT_TIME).unwrap();
    connection.flush().unwrap();
    let given = loop {
        if let Event::SelectionNotify(event) = connection.wait_for_event().unwrap() {
            break event.property;
        }
    };
    if given == x11rb::NONE {
        return None;
    }
    let reply =
        connection.get_property(true, window, kept, AtomEnum::ANY, 0, 1 << 20).unwrap().reply().unwrap();
    Some(String::from_utf8(reply.value).unwrap())
}

/// Drags from a place on the display by some pixels to the right, at a person's pace.
pub(crate) fn drag(display: &str, from: [&str; 2], right: &str) {
    let pause = || std::thread::sleep(Duration::from_millis(150));
    xdotool(display, &["mousemove", from[0], from[1]]).unwrap();
    pause();
    xdotool(display, &["mousedown", "1"]).unwrap();
    for _ in 0..2 {
        pause();
        xdotool(display, &["mousemove_relative", "--sync", "--", right, "0"]).unwrap();
    }
    pause();
    xdotool(display, &["mouseup", "1"]).unwrap();
}
