//! The program itself in a real window, on a display of the test's own: clicked, typed at, looked at, and closed.
//!
//! Needs Xvfb and xdotool; where they are missing the test says so and checks nothing, or fails where
//! `OVERLOOK_REQUIRE_WINDOW=1` asks for it.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use egui_kittest::kittest::Queryable;

use super::display::{
    can_drive_a_window, colors_on, drag, picture_of, quit, start_display, start_program, wait_for,
    wait_for_pictures, xdotool,
};
use super::driver::{SIZE, open, settle, small_capture};

/// Mean brightness of a part of the display, of 255: left, top, width and height, pixels.
fn brightness_of(display: &str, folder: &Path, [left, top, width, height]: [u32; 4]) -> f64 {
    let part = picture_of(display, folder).crop_imm(left, top, width, height).to_luma8();
    part.pixels().map(|pixel| f64::from(pixel.0[0])).sum::<f64>() / f64::from(width * height)
}

/// The left end of the top bar.
const TOP_BAR: [u32; 4] = [0, 0, 400, 40];

/// Beside the picture in the source view, which is dark there; a store has no such view, and its live view shows the sky there.
const BESIDE_SOURCE: [u32; 4] = [12, 230, 40, 150];

/// Where the widget of this name lies in the window: the same layout, off screen.
fn place_of(name: &str, capture: &Path, share_x: f32) -> [String; 2] {
    let mut window = open(overlook::app::Start::Path(capture.to_path_buf()), SIZE);
    settle(&mut window);
    let rect = window.get_by_label(name).rect();
    [rect.left() + rect.width() * share_x, rect.center().y].map(|place| format!("{place:.0}"))
}

#[test]
fn the_program_opens_a_window_that_answers_and_closes() {
    if !can_drive_a_window() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (_server, display) = start_display();
    let mut program = start_program(&display, folder.path(), &[]);
    wait_for_pictures(&display, folder.path());
    for keys in ["period", "period", "comma", "2", "space", "space", "w"] {
        xdotool(&display, &["key", keys]).unwrap();
    }
    let before = brightness_of(&display, folder.path(), TOP_BAR);
    // The theme switch at the right end of the top bar, then a drag in the live view.
    xdotool(&display, &["mousemove", "1252", "22", "click", "1"]).unwrap();
    wait_for("the other theme", || {
        let now = brightness_of(&display, folder.path(), TOP_BAR);
        ((now - before).abs() > 100.0).then_some(())
    });
    drag(&display, ["700", "400"], "40");
    std::thread::sleep(Duration::from_millis(500));
    assert!(program.0.try_wait().unwrap().is_none(), "the program is still there");
    assert!(colors_on(&display, folder.path()) > 2000, "the window still shows pictures");
    quit(&display, program);
}

/// Presses the button of the dialog of all ways out that asks where; without a dialog of the system, which may take a while to find out,
/// the field for a path appears.
fn choose_where(display: &str) {
    std::thread::sleep(Duration::from_secs(1));
    xdotool(display, &["key", "Return"]).unwrap();
    std::thread::sleep(Duration::from_secs(3));
}

#[test]
fn a_threshold_turned_in_the_window_is_in_the_store_it_saves_and_opens() {
    if !can_drive_a_window() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let capture = small_capture();
    let store = folder.path().join("saved.ovl");
    let path = store.to_str().unwrap();
    let (_server, display) = start_display();
    let program = start_program(&display, folder.path(), &[&capture]);
    wait_for_pictures(&display, folder.path());

    // The places are those of a window that is not seen for the first time.
    say(&display, "close the introduction");
    // The line on the depth tolerance's histogram; the work that this starts is canceled, and the next one runs through.
    let line = place_of("Depth tolerance on its histogram", &capture, 0.6);
    let [x, y] = line.each_ref().map(String::as_str);
    drag(&display, [x, y], "15");
    xdotool(&display, &["key", "Escape"]).unwrap();
    drag(&display, [x, y], "20");
    // Until the capture is pruned there is nothing to save: a busy machine is asked again.
    again_until(
        "the store",
        &display,
        || store.exists(),
        || {
            say(&display, "share: store");
            choose_where(&display);
            type_path(&display, path);
        },
    );
    let (samples, report) = overlook_engine::store::read(&store, &overlook_engine::job::Job::new()).unwrap();
    assert!(samples.settings.pruning.depth_tolerance > 1.5, "{}", samples.settings.pruning.depth_tolerance);
    let report = overlook_engine::preprocess::diagnostics::Report::from_json(&report, "saved").unwrap();
    assert_eq!(report.samples_kept, samples.sample_count());

    let is_open = || brightness_of(&display, folder.path(), BESIDE_SOURCE) > 100.0;
    assert!(!is_open(), "the capture is still there");
    again_until("the store in place of the capture", &display, is_open, || {
        xdotool(&display, &["key", "ctrl+o"]).unwrap();
        std::thread::sleep(Duration::from_secs(1));
        type_path(&display, path);
    });
    quit(&display, program);
}

/// Asks for something, and again where nothing came of it in the time that a busy machine may take.
fn again_until(what: &str, display: &str, is_done: impl Fn() -> bool, ask: impl Fn()) {
    wait_for(what, || {
        std::thread::sleep(Duration::from_secs(1));
        ask();
        for _ in 0..15 {
            std::thread::sleep(Duration::from_secs(1));
            if is_done() {
                return Some(());
            }
        }
        // Whatever waits for an answer goes.
        xdotool(display, &["key", "Escape"]).unwrap();
        None
    });
}

/// Types a path in place of what stands in the field that has the keyboard.
fn type_path(display: &str, path: &str) {
    xdotool(display, &["key", "ctrl+a"]).unwrap();
    xdotool(display, &["type", "--delay", "20", path]).unwrap();
    xdotool(display, &["key", "Return"]).unwrap();
}

/// Does something by its name, through the command palette.
fn say(display: &str, words: &str) {
    let pause = || std::thread::sleep(Duration::from_millis(700));
    xdotool(display, &["key", "ctrl+p"]).unwrap();
    pause();
    xdotool(display, &["type", "--delay", "15", words]).unwrap();
    pause();
    xdotool(display, &["key", "Return"]).unwrap();
    pause();
}

/// Types a path into the field that comes up where there is no dialog.
fn answer(display: &str, path: &Path) {
    std::thread::sleep(Duration::from_secs(1));
    type_path(display, path.to_str().unwrap());
    std::thread::sleep(Duration::from_secs(1));
}

/// Keeps a picture of a step, where somebody wants to see them.
fn keep_picture(display: &str, name: &str) {
    if let Some(folder) = std::env::var_os("OVERLOOK_WALK_PICTURES") {
        let file = Path::new(&folder).join(format!("{name}.png"));
        let taken =
            Command::new("import").args(["-window", "root"]).arg(&file).env("DISPLAY", display).status();
        assert!(taken.unwrap().success());
    }
}

#[test]
#[ignore = "walks for a minute: cargo test --test app -- --ignored; OVERLOOK_WALK_PICTURES=FOLDER keeps a picture of each step"]
fn the_ten_steps_of_the_guide_lead_from_a_folder_to_a_tuned_store() {
    if !can_drive_a_window() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let capture = small_capture();
    let [pixel, line] = [("Source picture", 0.5), ("Depth tolerance on its histogram", 0.6)]
        .map(|(name, share)| place_of(name, &capture, share));
    let (_server, display) = start_display();
    let mut program = start_program(&display, folder.path(), &[]);

    xdotool(&display, &["key", "ctrl+2"]).unwrap();
    say(&display, "open path");
    answer(&display, &capture);
    std::thread::sleep(Duration::from_secs(2));
    wait_for_pictures(&display, folder.path());
    std::thread::sleep(Duration::from_secs(2));
    keep_picture(&display, "1_open");
    say(&display, "source shows: kept by");
    keep_picture(&display, "2_who_won");
    xdotool(&display, &["mousemove", &pixel[0], &pixel[1], "click", "1"]).unwrap();
    xdotool(&display, &["key", "ctrl+shift+c"]).unwrap();
    std::thread::sleep(Duration::from_secs(1));
    keep_picture(&display, "3_pixel");
    say(&display, "open view: cameras");
    xdotool(&display, &["key", "f"]).unwrap();
    std::thread::sleep(Duration::from_secs(1));
    keep_picture(&display, "4_cameras");
    drag(&display, [line[0].as_str(), line[1].as_str()], "20");
    keep_picture(&display, "5_threshold");
    xdotool(&display, &["key", "ctrl+z", "ctrl+y"]).unwrap();
    say(&display, "kernel: block");
    keep_picture(&display, "6_history");
    say(&display, "open view: compare");
    std::thread::sleep(Duration::from_secs(3));
    keep_picture(&display, "7_compare");
    say(&display, "open view: time");
    keep_picture(&display, "8_time");
    say(&display, "open view: memory");
    keep_picture(&display, "8_memory");
    say(&display, "open view: sweep");
    say(&display, "run a sweep");
    std::thread::sleep(Duration::from_secs(4));
    keep_picture(&display, "9_sweep");
    say(&display, "cancel");

    let [store, settings, film] = ["tuned.ovl", "tuned.toml", "film.mp4"].map(at);
    wait_for("the store", || {
        xdotool(&display, &["key", "ctrl+s"]).unwrap();
        choose_where(&display);
        answer(&display, &store);
        store.exists().then_some(())
    });
    xdotool(&display, &["key", "Escape"]).unwrap();
    say(&display, "save settings");
    answer(&display, &settings);
    say(&display, "open view: live view");
    xdotool(&display, &["key", "k"]).unwrap();
    drag(&display, ["700", "300"], "40");
    xdotool(&display, &["key", "period", "k"]).unwrap();
    say(&display, "open view: camera path");
    keep_picture(&display, "10_path");
    say(&display, "share: video");
    choose_where(&display);
    answer(&display, &film);
    wait_for("the film", || film.exists().then_some(()));
    xdotool(&display, &["key", "Escape"]).unwrap();
    keep_picture(&display, "10_film");

    let (samples, _) = overlook_engine::store::read(&store, &overlook_engine::job::Job::new()).unwrap();
    let tuned = overlook_engine::settings::Settings::load(&settings).unwrap();
    assert!(tuned.pruning.depth_tolerance > 1.2, "{}", tuned.pruning.depth_tolerance);
    assert_eq!((samples.name.as_str(), &samples.settings.pruning), ("small_capture", &tuned.pruning));
    assert_eq!(tuned.render.kernel, overlook_engine::settings::Kernel::Block);
    xdotool(&display, &["key", "ctrl+q"]).unwrap();
    std::thread::sleep(Duration::from_secs(1));
    // The camera path and the sweep are lost: the button before Cancel, which has the focus, says to close anyway.
    xdotool(&display, &["key", "shift+Tab", "Return"]).unwrap();
    let status = wait_for("the program to end", || program.0.try_wait().unwrap());
    assert!(status.success(), "{status}");
}
