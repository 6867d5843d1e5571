//! How the window behaves beside its work: it explains itself, asks before it closes, and does anything by name.

use super::driver::{
    SIZE, Storage, Window, click, drag, drop_on, look_at, open, open_share, open_store, open_view,
    save_store, settle, share_path, share_to, shows, small_capture, small_demo, type_path, wait,
    wait_for_shared,
};
use egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use overlook::app::OverlookApp;

#[test]
fn a_first_run_explains_itself_and_the_next_one_remembers_the_layout() {
    let storage = std::sync::Arc::new(std::sync::Mutex::new(Storage::default()));
    let start = |storage: std::sync::Arc<std::sync::Mutex<Storage>>| -> Window {
        Harness::builder().with_size(SIZE).with_os(egui::os::OperatingSystem::Nix).build_eframe(move |cc| {
            OverlookApp::new(&cc.egui_ctx, Some(&*storage.lock().unwrap()), None, small_demo()).unwrap()
        })
    };
    let mut window = start(storage.clone());
    settle(&mut window);
    for title in ["Click a pixel", "Orbit the live view", "Change a threshold"] {
        assert!(shows(&window, title), "{title}");
    }
    click(&mut window, "Got it");
    assert!(window.query_by_label("Got it").is_none());
    open_view(&mut window, "Stress test");
    eframe::App::save(window.state_mut(), &mut *storage.lock().unwrap());
    let mut again = start(storage);
    settle(&mut again);
    assert!(again.query_by_label("Got it").is_none());
    assert!(shows(&again, "No stress test yet"), "the layout is as it was");
}

#[test]
fn the_first_run_does_not_explain_a_store_by_what_it_no_longer_has() {
    let folder = tempfile::tempdir().unwrap();
    let mut window: Window =
        Harness::builder().with_size(SIZE).with_os(egui::os::OperatingSystem::Nix).build_eframe(move |cc| {
            OverlookApp::new(&cc.egui_ctx, Some(&Storage::default()), None, small_demo()).unwrap()
        });
    settle(&mut window);
    let path = save_store(&mut window, folder.path());
    assert!(shows(&window, "Orbit the live view"));
    open_store(&mut window, &path);
    assert!(window.query_by_label("Got it").is_none());
}

/// What the cross in the window's corner does.
fn close(window: &mut Window) {
    let viewport = window.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
    viewport.events.push(egui::ViewportEvent::Close);
    window.run_steps(3);
}

#[test]
fn closing_while_pictures_are_written_asks_first() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Camera path");
    for _ in 0..12 {
        window.key_press(Key::K);
        window.run_steps(2);
    }
    share_path(&mut window, &[("Pictures of", "Camera path")], folder.path());
    wait(&mut window, "the export", |window| window.query_by_label("Path").is_none());
    click(&mut window, "Close sharing");
    close(&mut window);
    assert!(shows(&window, "Close before all is written?"));
    click(&mut window, "Cancel closing");
    assert!(!shows(&window, "Close before all is written?"));
    click(&mut window, "Cancel");
    settle(&mut window);
    close(&mut window);
    assert!(!shows(&window, "Close before all is written?") && !shows(&window, "Close now?"));
    assert!(shows(&window, "the camera path (12 keys)"));
}

#[test]
fn a_camera_path_is_lost_only_after_a_question() {
    let capture = small_capture();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    window.key_press(Key::K);
    window.run_steps(2);
    close(&mut window);
    assert!(shows(&window, "Close without saving?") && shows(&window, "the camera path (1 key)"));
    click(&mut window, "Cancel closing");
    window.key_press(Key::K);
    window.run_steps(2);
    for _ in 0..2 {
        drop_on(&mut window, &capture);
        // The path is looked at first, on a thread of its own.
        wait(&mut window, "the question", |window| shows(window, "Open something else?"));
        assert!(shows(&window, "the camera path (2 keys)"));
        assert!(window.query_by_label("Save camera path…").is_some(), "what would be lost can be saved");
        window.key_press(Key::Escape);
        window.run_steps(3);
        assert!(!shows(&window, "Open something else?"));
    }
    assert_eq!(window.state().observed().scene_name, Some("orrery"));
    drop_on(&mut window, "/no/such/capture".as_ref());
    wait(&mut window, "the message", |window| !window.state().observed().notices.is_empty());
    assert!(!shows(&window, "Open something else?"), "nothing is given up for a path that does not exist");
    window.key_press(Key::Escape);
    window.run_steps(3);
    drop_on(&mut window, &capture);
    wait(&mut window, "the question", |window| shows(window, "Open something else?"));
    // Cancel has the focus; what discards comes before it.
    for (modifiers, key) in [(Modifiers::SHIFT, Key::Tab), (Modifiers::NONE, Key::Enter)] {
        window.key_press_modifiers(modifiers, key);
        window.run_steps(3);
    }
    wait(&mut window, "the capture", |window| window.state().observed().scene_name == Some("small_capture"));
    settle(&mut window);
    close(&mut window);
    assert!(!shows(&window, "Close without saving?"));
}

#[test]
fn a_path_that_is_taken_asks_in_its_field_and_a_second_press_replaces() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("settings.toml");
    std::fs::write(&path, "old").unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    type_path(&mut window, "Save settings", &path, "Save this path");
    wait(&mut window, "the question", |window| shows(window, "It exists already."));
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(3);
    wait(&mut window, "the file", |_| std::fs::read(&path).is_ok_and(|now| now != b"old"));
    assert!(window.query_by_label("Path").is_none());
}

#[test]
fn what_an_empty_view_offers_is_within_it() {
    let mut window = open(small_demo(), [SIZE[0], 620.0]);
    settle(&mut window);
    for (view, button) in [
        ("Camera path", "Add key here (K)"),
        ("Sweep", "Run a sweep…"),
        ("Stress test", "Run a stress test…"),
    ] {
        open_view(&mut window, view);
        let (offered, below) =
            (window.get_by_label(button).rect(), window.get_by_label("Timeline").rect().top());
        assert!(offered.height() > 10.0 && offered.bottom() <= below, "{view}: {offered:?}, {below}");
    }
}

#[test]
fn closing_with_changed_thresholds_asks_first() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    close(&mut window);
    assert!(!shows(&window, "Close without saving?"), "nothing was changed");
    drag(&mut window, "Depth tolerance on its histogram", vec2(0.6, 0.6), vec2(30.0, 0.0));
    settle(&mut window);
    close(&mut window);
    assert!(shows(&window, "Close without saving?"));
    click(&mut window, "Cancel closing");
    assert!(!shows(&window, "Close without saving?"));
}

#[test]
fn a_scene_that_plays_says_why_it_gives_no_verdict_and_a_clicked_pixel_stops_it() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    click(&mut window, "Play");
    wait(&mut window, "time to pass", |window| window.state().observed().frame > 0);
    let picture = window.get_by_label("Source picture").rect();
    window.hover_at(picture.center());
    wait(&mut window, "a word on why there is no verdict", |window| {
        shows(window, "Playing: pause, or click")
    });
    assert!(!shows(&window, "Infinitely far"), "nothing is said of a depth that nobody asked for");
    look_at(&mut window, "Source picture", vec2(0.5, 0.6));
    settle(&mut window);
    assert!(shows(&window, "this pixel") && window.query_by_label("Play").is_some());
    let frame = window.state().observed().frame;
    window.run_steps(20);
    assert_eq!(window.state().observed().frame, frame);
}

#[test]
fn the_palette_does_anything_by_its_name() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(3);
    window.get_by_label("Command").type_text("view stress");
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert!(shows(&window, "No stress test yet") && window.query_by_label("Command").is_none());
    click(&mut window, "Commands");
    window.get_by_label("Command").type_text("pruning method off");
    window.run_steps(3);
    click(&mut window, "Do: Pruning method: Off");
    settle(&mut window);
    let (report, _) = window.state().observed().report.unwrap();
    assert_eq!(
        window.state().observed().settings.pruning.method,
        overlook_engine::settings::PruningMethod::Off
    );
    assert!(report.samples_kept > 0);
}

#[test]
fn the_sheet_of_keys_opens_and_closes() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    click(&mut window, "Help");
    click(&mut window, "Keyboard and mouse shortcuts");
    assert!(shows(&window, "Keyboard and mouse shortcuts") && shows(&window, "find any command by name"));
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(!shows(&window, "Keyboard and mouse shortcuts"));
}

#[test]
fn a_camera_path_is_set_played_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = folder.path().join("pictures");
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Camera path");
    assert!(shows(&window, "No camera path yet"));
    window.key_press(Key::K);
    window.run_steps(2);
    let start = window.state().observed().live_position.unwrap();
    drag(&mut window, "Live picture", vec2(0.5, 0.5), vec2(80.0, 10.0));
    window.key_press(Key::Period);
    window.key_press(Key::K);
    settle(&mut window);
    let end = window.state().observed().live_position.unwrap();
    assert_ne!(start, end);
    click(&mut window, "Key 1");
    assert_eq!(window.state().observed().live_position.unwrap(), start);
    click(&mut window, "Play path");
    wait(&mut window, "the end of the path", |window| {
        let at = window.state().observed().live_position.unwrap();
        at.iter().zip(end).all(|(a, b)| (a - b).abs() < 1e-6)
    });
    settle(&mut window);
    share_path(&mut window, &[("Pictures of", "Camera path")], &pictures);
    wait_for_shared(&mut window);
    assert_eq!(std::fs::read_dir(&pictures).unwrap().count(), 49);
    let first = image::open(pictures.join("0001.png")).unwrap();
    assert!(first.width() > 20);
    let film = folder.path().join("no/such/folder/film.mp4");
    open_share(&mut window, "Video");
    share_to(&mut window, &film, "Export");
    wait(&mut window, "what went wrong", |window| shows(window, "Could not export"));
    assert!(!film.exists());
}

#[test]
fn a_turn_around_the_pivot_is_made_and_closed_and_its_keys_change_places() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Camera path");
    click(&mut window, "Turntable…");
    click(&mut window, "Turn around the pivot");
    settle(&mut window);
    // Eight seconds at 24 pictures a second.
    assert!(shows(&window, "192 pictures") && shows(&window, "Time stands still in the film"));
    click(&mut window, "Loop");
    assert!(shows(&window, "177 pictures"), "from the first of twelve keys to the last");
    click(&mut window, "Key 1");
    let first = window.state().observed().live_position.unwrap();
    click(&mut window, "Move key 1 down");
    click(&mut window, "Key 2");
    assert_eq!(window.state().observed().live_position.unwrap(), first);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(3);
    click(&mut window, "Key 1");
    assert_eq!(window.state().observed().live_position.unwrap(), first);
}

#[test]
fn keys_of_the_camera_path_are_dragged_on_the_time_bar() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Camera path");
    window.key_press(Key::K);
    for _ in 0..3 {
        window.key_press(Key::Period);
    }
    window.key_press(Key::K);
    settle(&mut window);
    assert!(shows(&window, "frame 4"));
    let column = window.get_by_label("Timeline").rect().width() / 4.0;
    drag(&mut window, "Key 2 on the time bar", vec2(0.5, 0.5), vec2(-column, 0.0));
    settle(&mut window);
    assert!(shows(&window, "frame 3") && !shows(&window, "frame 4"));
    // The first key stops it, and the bar itself is not dragged meanwhile.
    drag(&mut window, "Key 2 on the time bar", vec2(0.5, 0.5), vec2(-9.0 * column, 0.0));
    settle(&mut window);
    assert!(shows(&window, "frame 1") && !shows(&window, "frame 3"));
}

#[test]
fn the_picture_of_the_live_view_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("live.png");
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_share(&mut window, "Pictures");
    share_to(&mut window, &path, "Save");
    wait(&mut window, "the picture", |_| path.is_file());
    settle(&mut window);
    let saved = image::open(&path).unwrap();
    let ([width, height], _) = window.state().observed().live_coverage.unwrap();
    assert_eq!((saved.width() as usize, saved.height() as usize), (width, height));
}

#[test]
fn twice_the_scale_shows_the_same_window() {
    let start = small_demo();
    let mut window: Window = Harness::builder()
        .with_size(SIZE)
        .with_pixels_per_point(2.0)
        .with_os(egui::os::OperatingSystem::Nix)
        .build_eframe(move |cc| OverlookApp::new(&cc.egui_ctx, None, None, start).unwrap());
    settle(&mut window);
    for name in ["Source picture", "Live picture", "Settings", "Pixel", "Timeline"] {
        let area = window.get_by_label(name).rect();
        assert!(
            area.width() > 20.0 && area.right() <= SIZE[0] && area.bottom() <= SIZE[1],
            "{name}: {area:?}"
        );
    }
}
