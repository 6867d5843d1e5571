//! Drives the window off screen: no display needed, a software Vulkan adapter is enough.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, HarnessBuilder};
use overlook::app::{OverlookApp, Start};
use overlook_engine::demo::DemoSpec;

/// Longest any single wait takes before the test fails: far more than needed, as test machines stall.
const PATIENCE: Duration = Duration::from_mins(3);

/// A display shows no more pictures than one in so long.
const REFRESH: Duration = Duration::from_millis(16);

/// Longest that a window goes undrawn, so that one that fails to ask for it fails by what it shows and not by time.
const UNDRAWN: Duration = Duration::from_millis(500);

/// A window with a harness around it.
pub(crate) type Window = Harness<'static, OverlookApp>;

/// Size of the window unless a test is about another.
pub(crate) const SIZE: [f32; 2] = [1280.0, 800.0];

/// A small recording of a built-in scene, quick to trace and to prune.
pub(crate) fn small_demo() -> Start {
    demo(3, 4, (96, 72))
}

/// A recording of the orrery.
pub(crate) fn demo(cameras: usize, frames: usize, size: (u32, u32)) -> Start {
    Start::Demo(DemoSpec::new("orrery").cameras(cameras).frames(frames).size(size))
}

/// The small capture of a renderer's pictures that the repository carries.
pub(crate) fn small_capture() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/small_capture")
}

/// The small capture in a folder of the test's own, its manifest changed.
pub(crate) fn changed_capture(folder: &Path, change: impl FnOnce(&mut serde_json::Value)) -> PathBuf {
    let (from, to) = (small_capture(), folder.join("changed"));
    for camera in ["cam0", "cam1", "cam2", "cam3"] {
        std::fs::create_dir_all(to.join(camera)).unwrap();
        for file in std::fs::read_dir(from.join(camera)).unwrap() {
            let file = file.unwrap();
            std::fs::copy(file.path(), to.join(camera).join(file.file_name())).unwrap();
        }
    }
    let text = std::fs::read_to_string(from.join("transforms.json")).unwrap();
    let mut manifest = serde_json::from_str(&text).unwrap();
    change(&mut manifest);
    std::fs::write(to.join("transforms.json"), manifest.to_string()).unwrap();
    to
}

/// Opens a window of the given size.
pub(crate) fn open(start: Start, size: [f32; 2]) -> Window {
    let builder: HarnessBuilder<OverlookApp> =
        Harness::builder().with_size(size).with_os(egui::os::OperatingSystem::Nix).with_render_cursor(false);
    builder.build_eframe(move |cc| OverlookApp::new(&cc.egui_ctx, None, None, start).unwrap())
}

/// Opens a window on a fresh profile, which explains itself.
pub(crate) fn open_fresh(start: Start, size: [f32; 2]) -> Window {
    let builder: HarnessBuilder<OverlookApp> =
        Harness::builder().with_size(size).with_os(egui::os::OperatingSystem::Nix).with_render_cursor(false);
    builder.build_eframe(move |cc| {
        OverlookApp::new(&cc.egui_ctx, Some(&Storage::default()), None, start).unwrap()
    })
}

/// What a window remembers from one run to the next; an empty one is that of a fresh profile.
#[derive(Default)]
pub(crate) struct Storage(std::collections::HashMap<String, String>);

impl eframe::Storage for Storage {
    fn get_string(&self, key: &str) -> Option<String> {
        self.0.get(key).cloned()
    }

    fn set_string(&mut self, key: &str, value: String) {
        self.0.insert(key.to_owned(), value);
    }

    fn remove_string(&mut self, key: &str) {
        self.0.remove(key);
    }

    fn flush(&mut self) {}
}

/// Whether some label on screen holds `text`.
pub(crate) fn shows(window: &Window, text: &str) -> bool {
    window.query_all_by_label_contains(text).next().is_some()
}

/// Whether some message on screen begins so.
pub(crate) fn told(window: &Window, start: &str) -> bool {
    window.state().observed().notices.iter().any(|notice| notice.starts_with(start))
}

/// A file or folder that is dropped on the window.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// Drops a file or folder on the window; the next step takes it in.
pub(crate) fn drop_on(window: &mut Window, path: &Path) {
    window.input_mut().dropped_files.push(Arc::new(Dropped(path.to_path_buf())));
}

/// When a window wants to be drawn next, as it told egui.
#[derive(Clone, Default)]
struct Wanted(Arc<Mutex<Option<Instant>>>);

impl Wanted {
    fn of(window: &Window) -> Self {
        let id = egui::Id::unique("wanted by tests");
        if let Some(wanted) = window.ctx.data(|data| data.get_temp(id)) {
            return wanted;
        }
        // What was asked for before nobody listened.
        let wanted = Self(Arc::new(Mutex::new(Some(Instant::now()))));
        window.ctx.data_mut(|data| data.insert_temp(id, wanted.clone()));
        let told = wanted.clone();
        window.ctx.set_request_repaint_callback(move |request| {
            let (asked, mut next) = (Instant::now() + request.delay, told.0.lock().unwrap());
            *next = Some(next.map_or(asked, |next| next.min(asked)));
        });
        wanted
    }

    fn is_due(&self) -> bool {
        self.0.lock().unwrap().is_some_and(|next| next <= Instant::now())
    }
}

/// Draws the window whenever it asks for it, as a display does, until `condition` holds: work has the processor meanwhile.
pub(crate) fn wait(window: &mut Window, what: &str, mut condition: impl FnMut(&Window) -> bool) {
    let (started, wanted) = (Instant::now(), Wanted::of(window));
    let mut drawn: Option<Instant> = None;
    while !condition(window) {
        let notices = || window.state().observed().notices;
        assert!(started.elapsed() < PATIENCE, "waited too long for {what}; messages: {:?}", notices());
        let undrawn = drawn.map_or(UNDRAWN, |at| at.elapsed());
        if undrawn >= UNDRAWN || (undrawn >= REFRESH && wanted.is_due()) {
            *wanted.0.lock().unwrap() = None;
            drawn = Some(Instant::now());
            window.step();
        } else {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// Steps the window until all work is done and shown.
pub(crate) fn settle(window: &mut Window) {
    window.step();
    wait(window, "all work to be done", |window| window.state().observed().is_idle);
    window.run_steps(3);
}

/// Clicks the widget with this accessible name.
pub(crate) fn click(window: &mut Window, name: &str) {
    window.get_by_label(name).click();
    window.run_steps(3);
}

/// What the window leaves on the clipboard within the next frames.
pub(crate) fn copied(window: &mut Window) -> Option<String> {
    let mut copied = None;
    for _ in 0..4 {
        window.step();
        for command in &window.output().platform_output.commands {
            if let egui::OutputCommand::CopyText(text) = command {
                copied = Some(text.clone());
            }
        }
    }
    copied
}

/// Brings a view to the front by the menu.
pub(crate) fn open_view(window: &mut Window, view: &str) {
    click(window, "Panels");
    click(window, &format!("Open view {view}"));
    settle(window);
}

/// Measures what a sweep or a stress test offers.
pub(crate) fn measure(window: &mut Window, study: &str) {
    click(window, study);
    // The dialog takes its place after its first frames.
    window.run_steps(4);
    click(window, "Start measuring");
}

/// Picks an entry of a drop-down list.
pub(crate) fn pick(window: &mut Window, list: &str, entry: &str) {
    click(window, list);
    // The list's own button may already show the entry; the popup's comes last.
    window.get_all_by_label(entry).last().unwrap().click();
    window.run_steps(3);
}

/// Drags from a place in a widget, as shares of its size, by some points.
pub(crate) fn drag(window: &mut Window, name: &str, from: egui::Vec2, by: egui::Vec2) {
    let area = window.get_by_label(name).rect();
    let start = area.min + area.size() * from;
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    };
    window.event(egui::Event::PointerMoved(start));
    window.event(button(start, true));
    window.step();
    for share in [0.3, 0.6, 1.0] {
        window.event(egui::Event::PointerMoved(start + by * share));
        window.step();
    }
    window.event(button(start + by, false));
    window.run_steps(2);
}

/// Opens or closes what is folded below a line of this name.
pub(crate) fn fold(window: &mut Window, name: &str) {
    window.get_all_by_label(name).next().unwrap().scroll_to_me();
    window.run_steps(3);
    window.get_all_by_label(name).next().unwrap().click();
    // It opens by and by.
    window.run_steps(8);
    settle(window);
}

/// Clicks the button of holes until it says so.
pub(crate) fn show_holes(window: &mut Window, choice: &str) {
    for _ in 0..3 {
        if window.query_by_label(&format!("Holes: {choice}")).is_some() {
            return;
        }
        window.get_by_label_contains("Holes: ").click();
        window.run_steps(3);
    }
}

/// Copies a table by the button beside the tab of its view.
pub(crate) fn copy_table(window: &mut Window, view: &str, form: &str, table: &str) {
    click(window, &format!("Export {view}"));
    let entry = format!("Copy {form} of the {table}");
    if window.query_by_label(&entry).is_none() {
        let menu = format!("{}{}", table[..1].to_uppercase(), &table[1..]);
        window.get_by_label_contains(&menu).click();
        window.run_steps(3);
    }
    window.get_by_label(&entry).click();
}

/// Clicks one of a row of choices.
pub(crate) fn choose(window: &mut Window, row: &str, choice: &str) {
    click(window, &format!("{row}: {choice}"));
}

/// Does what an entry of the command palette says.
pub(crate) fn do_command(window: &mut Window, entry: &str) {
    click(window, "Commands");
    window.get_by_label("Command").type_text(entry);
    window.run_steps(3);
    click(window, &format!("Do: {entry}"));
}

/// Types a path into the field that comes up in place of the system's dialog, and takes it; an entry of the command palette asks for it.
pub(crate) fn type_path(window: &mut Window, entry: &str, path: &Path, take: &str) {
    do_command(window, entry);
    window.get_by_label("Path").replace_selected_text_accesskit("");
    window.run_steps(2);
    window.get_by_label("Path").set_text_value_accesskit(&path.display().to_string());
    window.run_steps(3);
    click(window, take);
}

/// Opens the dialog of all ways out at one of them, and waits for the sizes.
pub(crate) fn open_share(window: &mut Window, way: &str) {
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::E);
    window.run_steps(3);
    settle(window);
    let start = format!("{way}: ");
    window.get_by_label_contains(&start).click();
    window.run_steps(3);
}

/// Types a path into the dialog of all ways out, and takes it: `action` is what its field's button says.
pub(crate) fn share_to(window: &mut Window, path: &Path, action: &str) {
    let names = ["Save the ", "Save pictures", "Make the "];
    let is_way = |node: &egui_kittest::kittest::AccessKitNode<'_>| {
        let label = node.label().unwrap_or_default();
        names.iter().any(|name| label.starts_with(name)) && label.ends_with('…')
    };
    window.query_all_by(is_way).next().unwrap().click();
    window.run_steps(3);
    window.get_by_label("Path").replace_selected_text_accesskit("");
    window.run_steps(2);
    window.get_by_label("Path").set_text_value_accesskit(&path.display().to_string());
    window.run_steps(3);
    click(window, &format!("{action} this path"));
}

/// Waits until what was shared is written, and closes the dialog.
pub(crate) fn wait_for_shared(window: &mut Window) {
    wait(window, "what is shared", |window| shows(window, "Show in folder"));
    // The dialog makes room for the outcome.
    window.run_steps(3);
    click(window, "Close sharing");
}

/// Exports along the camera path into a folder or file: `choices` are those of the dialog.
pub(crate) fn share_path(window: &mut Window, choices: &[(&str, &str)], path: &Path) {
    open_share(window, "Pictures");
    for (row, choice) in choices {
        choose(window, row, choice);
    }
    share_to(window, path, "Export");
}

/// Saves a store into a folder, and gives its path once it is whole.
pub(crate) fn save_store(window: &mut Window, folder: &Path) -> PathBuf {
    let path = folder.join("orrery.ovl");
    open_share(window, "Store");
    share_to(window, &path, "Save");
    wait_for_shared(window);
    assert!(path.is_file());
    path
}

/// Opens a store.
pub(crate) fn open_store(window: &mut Window, path: &Path) {
    type_path(window, "Open file", path, "Open this path");
    // Its source frames are not there, and neither is their view.
    wait(window, "the store", |window| !window.state().observed().views_in_sight.contains(&"Source"));
    settle(window);
}

/// Clicks a place in a picture, as shares of its size, so that the pixel there is kept.
pub(crate) fn look_at(window: &mut Window, picture: &str, share: egui::Vec2) {
    let area = window.get_by_label(picture).rect();
    let at = area.min + area.size() * share;
    window.hover_at(at);
    window.run_steps(2);
    for pressed in [true, false] {
        window.event(egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        });
        window.step();
    }
    wait(window, "the argument", |window| window.state().observed().probed_pixel.is_some());
}
