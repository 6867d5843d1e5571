//! The dialog of all ways out, and addresses of views.

use egui::{Event, Key, Modifiers, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use overlook::app::Start;

use super::driver::{
    SIZE, Window, choose, click, copied, drag, open, open_share, open_view, save_store, settle, share_path,
    share_to, shows, small_capture, small_demo, told, wait, wait_for_shared,
};

const WAYS: [&str; 8] =
    ["Interactive page", "Splats", "Video", "Pictures", "Figure", "Points", "Cameras", "Store"];

/// What stands in the list beside a way.
fn size_of(window: &Window, way: &str) -> String {
    let start = format!("{way}: ");
    let row = window.get_by_label_contains(&start).accesskit_node().label().unwrap();
    row.strip_prefix(&start).unwrap().to_owned()
}

#[test]
fn all_ways_out_have_a_size_before_they_are_made_and_a_sentence_of_what_they_are_for() {
    let mut window = open(Start::Path(small_capture()), SIZE);
    settle(&mut window);
    click(&mut window, "Save");
    click(&mut window, "Share…");
    settle(&mut window);
    for way in WAYS {
        let size = size_of(&window, way);
        let has_unit = ["B", "kB", "MB"].iter().any(|unit| size.contains(&format!(" {unit}")));
        assert!(size.starts_with("about ") && has_unit, "{way}: {size}");
    }
    for (way, word) in WAYS.into_iter().zip([
        "browser",
        "engines",
        "camera path",
        "view",
        "for print",
        "measure",
        "lens",
        "opens",
    ]) {
        open_share(&mut window, way);
        assert!(shows(&window, word), "{way} does not say what it is for");
        let names = ["Save the ", "Save pictures", "Make the "];
        let makes = names.iter().any(|name| shows(&window, name));
        assert!(makes, "{way} cannot be made");
    }
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(window.query_by_label("Close sharing").is_none());
}

#[test]
fn a_page_is_made_of_about_the_size_that_was_said_and_nothing_else_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.html");
    let mut window = open(Start::Path(small_capture()), SIZE);
    settle(&mut window);
    open_share(&mut window, "Interactive page");
    window.get_by_label("Title of the page").set_text_value_accesskit("Four views of a desk");
    window.run_steps(3);
    let said = size_of(&window, "Interactive page");
    share_to(&mut window, &path, "Export");
    wait(&mut window, "the page", |window| shows(window, "Show in folder"));
    assert!(shows(&window, "A page of "), "the dialog says what was written");
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(page.contains("<title>Four views of a desk") && page.contains("</html>"));
    let [number, unit] =
        said.strip_prefix("about ").unwrap().split(' ').collect::<Vec<_>>().try_into().unwrap();
    let scale = if unit == "MB" { 1e6 } else { 1e3 };
    let ratio = number.parse::<f64>().unwrap() * scale / page.len() as f64;
    assert!((0.7..1.4).contains(&ratio), "{said} for {} bytes", page.len());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    // A name of another kind of file is not taken.
    share_to(&mut window, &folder.path().join("store.ovl"), "Export");
    assert!(shows(&window, "A file of this kind is named .html."));
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(window.query_by_label("Close sharing").is_some(), "only the topmost thing closes");
}

#[test]
fn splats_points_and_stores_are_written_by_the_formats_that_are_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    for (format, begins) in
        [("PLY", &b"ply\n"[..]), ("GLB", b"glTF"), ("SPZ", b"\x1f\x8b"), ("USDA", b"#usda")]
    {
        open_share(&mut window, "Splats");
        choose(&mut window, "Format", format);
        let path = folder.path().join("scene").with_extension(format.to_lowercase());
        share_to(&mut window, &path, "Export");
        wait_for_shared(&mut window);
        assert!(std::fs::read(&path).unwrap().starts_with(begins), "{format}");
    }
    open_share(&mut window, "Points");
    choose(&mut window, "Points of", "Every frame");
    let points = folder.path().join("points");
    share_to(&mut window, &points, "Export");
    wait_for_shared(&mut window);
    assert_eq!(std::fs::read_dir(&points).unwrap().count(), 4);
    save_store(&mut window, folder.path());
}

#[test]
fn a_figure_shows_the_live_view_or_the_source_picture_with_what_its_colors_mean() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    choose(&mut window, "Source shows", "Motion");
    choose(&mut window, "Live view shows", "Camera");
    settle(&mut window);
    let mut shared = |of: &str, name: &str| {
        open_share(&mut window, "Figure");
        choose(&mut window, "Figure of", of);
        window.get_by_label("Caption of the figure").set_text_value_accesskit("Seen by five cameras.");
        window.run_steps(3);
        let path = folder.path().join(name);
        share_to(&mut window, &path, "Export");
        wait_for_shared(&mut window);
        std::fs::read(path).unwrap()
    };
    let source = String::from_utf8(shared("Source picture", "source.svg")).unwrap();
    assert!(source.contains("stored for all frames") && source.contains("Seen by five cameras."));
    let live = String::from_utf8(shared("Live view", "live.svg")).unwrap();
    assert!(live.contains(" m, at ") && live.matches("<rect").count() > 4, "cameras have their colors");
    assert!(shared("Live view", "live.pdf").starts_with(b"%PDF"));
    assert_eq!(image::load_from_memory(&shared("Live view", "live.png")).unwrap().width(), 1417);
}

/// The image that the window leaves on the clipboard.
fn copied_image(window: &mut Window) -> [usize; 2] {
    let mut image = None;
    wait(window, "the image", |window| {
        for command in &window.output().platform_output.commands {
            if let egui::OutputCommand::CopyImage(copied) = command {
                image = Some(copied.size);
            }
        }
        image.is_some()
    });
    window.run_steps(2);
    image.unwrap()
}

/// Rows of the figure that the key copies while the pointer is over a view.
fn rows_of_copied_figure(window: &mut Window, view: &str) -> usize {
    let area = window.get_by_label(view).rect();
    window.hover_at(area.center());
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::F);
    let [columns, rows] = copied_image(window);
    assert_eq!(columns, 1417, "120 mm at 300 dpi");
    assert!(shows(window, &format!("{columns}×{rows} pixels, 120 mm wide")), "{view}");
    rows
}

#[test]
fn one_key_copies_the_figure_of_the_view_under_the_pointer() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let [live, source] =
        ["Live picture", "Source picture"].map(|view| rows_of_copied_figure(&mut window, view));
    assert!(live > 300 && source > 300);
}

#[test]
fn a_figure_shows_the_comparison_as_it_is_compared() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_share(&mut window, "Figure");
    choose(&mut window, "Figure of", "Comparison");
    assert!(shows(&window, "There is no comparison: open Compare"), "the dialog says what is missing");
    click(&mut window, "Close sharing");
    open_view(&mut window, "Compare");
    wait(&mut window, "the comparison", |window| shows(window, "of pixels covered on one side only"));
    let mut shared = |mode: &str, measure: Option<&str>| {
        choose(&mut window, "Compare by", mode);
        if let Some(measure) = measure {
            choose(&mut window, "Difference in", measure);
        }
        settle(&mut window);
        open_share(&mut window, "Figure");
        choose(&mut window, "Figure of", "Comparison");
        let path = folder.path().join(format!("{mode} {}.svg", measure.unwrap_or_default()));
        share_to(&mut window, &path, "Export");
        wait_for_shared(&mut window);
        std::fs::read_to_string(path).unwrap()
    };
    let wiped = shared("Wipe", None);
    assert!(wiped.contains("Left: All samples") && wiped.contains("Right: Kept samples"));
    assert!(shared("Side by side", None).contains("Right: Kept samples"));
    let flipped = shared("Flip", None);
    assert!(flipped.contains("All samples") && !flipped.contains("Kept samples"), "one side is shown");
    let signed = shared("Difference", Some("Signed"));
    for text in
        ["Difference of All samples and Kept samples", "brighter, 8-bit steps", "no sample on one side"]
    {
        assert!(signed.contains(text), "{text}");
    }
    assert!(shared("Difference", Some("FLIP")).contains("FLIP 0"));
    assert!(rows_of_copied_figure(&mut window, "Comparison") > 300);
}

#[test]
fn hidden_cameras_are_left_out_of_the_store_by_one_edit_that_is_taken_back() {
    const NOTE: &str = "Cameras that the live view leaves out are in it as well.";
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_share(&mut window, "Store");
    assert!(!shows(&window, NOTE), "all cameras are shown");
    click(&mut window, "Close sharing");
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(3);
    window.get_by_label("Command").type_text("solo camera left");
    window.run_steps(3);
    click(&mut window, "Do: Solo camera left");
    settle(&mut window);
    open_share(&mut window, "Store");
    assert!(shows(&window, NOTE));
    click(&mut window, "Leave hidden cameras out");
    settle(&mut window);
    assert!(!shows(&window, NOTE), "there is none in it any more");
    click(&mut window, "Close sharing");
    open_view(&mut window, "Edits");
    assert_eq!(window.get_all_by_label_contains("Name of edit").count(), 1, "one edit for both");
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert!(shows(&window, "No edits yet"));
}

/// Opens the menu of a picture.
fn open_menu(window: &mut Window, picture: &str) {
    window.get_by_label(picture).click_secondary();
    window.run_steps(3);
}

#[test]
fn a_right_click_on_a_picture_copies_it_or_its_figure_and_leads_to_saving_one() {
    const ADDRESS: &str = "Copy the address of this view";
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    // Cameras have a menu of their own.
    click(&mut window, "Hide cameras");
    choose(&mut window, "Source shows", "Motion");
    settle(&mut window);
    open_menu(&mut window, "Live picture");
    assert!(window.query_by_label(ADDRESS).is_some() && window.query_by_label("Solo").is_none());
    window.get_by_label("Copy picture").click();
    let shown = window.state().observed().live_coverage.unwrap().0;
    assert_eq!(copied_image(&mut window), shown, "as it is rendered for the view");
    open_menu(&mut window, "Source picture");
    assert!(window.query_by_label(ADDRESS).is_none(), "a source picture has none");
    window.get_by_label("Copy picture").click();
    assert_eq!(copied_image(&mut window), [96, 72]);
    open_menu(&mut window, "Source picture");
    window.get_by_label("Copy figure").click();
    assert_eq!(copied_image(&mut window)[0], 1417);
    open_menu(&mut window, "Source picture");
    click(&mut window, "Save figure…");
    settle(&mut window);
    let path = folder.path().join("motion.svg");
    share_to(&mut window, &path, "Export");
    wait_for_shared(&mut window);
    assert!(std::fs::read_to_string(&path).unwrap().contains("stored for all frames"));
    open_view(&mut window, "Compare");
    wait(&mut window, "the comparison", |window| shows(window, "of pixels covered on one side only"));
    open_menu(&mut window, "Comparison");
    window.get_by_label("Copy picture").click();
    let [columns, rows] = copied_image(&mut window);
    assert!(shows(&window, &format!("The picture is on the clipboard: {columns}×{rows} pixels.")));
}

#[test]
fn a_comparison_is_filmed_with_and_without_a_camera_path() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_share(&mut window, "Pictures");
    choose(&mut window, "Pictures of", "Camera path");
    choose(&mut window, "Shows", "Wipe");
    assert!(shows(&window, "All samples and Kept samples, as chosen in Compare, over the played frames."));
    let pictures = folder.path().join("pictures");
    share_to(&mut window, &pictures, "Export");
    wait_for_shared(&mut window);
    assert_eq!(std::fs::read_dir(&pictures).unwrap().count(), 4, "one for each frame");
    let second = image::open(pictures.join("0002.png")).unwrap().into_rgb8();
    // The names of the sides stand below.
    let height = second.width() * 3 / 4;
    assert!(second.height() > height);
    let is_white = |x: u32| (0..height).all(|y| second.get_pixel(x, y).0 == [255; 3]);
    let line: Vec<u32> = (0..second.width()).filter(|x| is_white(*x)).collect();
    let middle = second.width() * 2 / 3;
    assert_eq!(line, [middle - 1, middle], "the line is where a third of the film has passed");

    for _ in 0..2 {
        window.key_press(Key::K);
        window.run_steps(2);
    }
    open_share(&mut window, "Video");
    choose(&mut window, "Shows", "Flip");
    assert!(shows(&window, "along the camera path."));
    let video = folder.path().join("flip.mp4");
    share_to(&mut window, &video, "Export");
    wait_for_shared(&mut window);
    assert_eq!(&std::fs::read(&video).unwrap()[4..8], b"ftyp");
}

#[test]
fn what_is_written_is_canceled_in_the_dialog_and_it_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    for _ in 0..80 {
        window.key_press(Key::K);
        window.run_steps(2);
    }
    share_path(&mut window, &[("Pictures of", "Camera path")], &folder.path().join("pictures"));
    wait(&mut window, "the work", |window| window.query_by_label("Cancel sharing").is_some());
    let before = window.get_by_label("Cancel sharing").rect();
    wait(&mut window, "a count", |window| window.query_by_label("Progress of sharing").is_some());
    assert_eq!(window.get_by_label("Cancel sharing").rect(), before, "it stays under the pointer");
    click(&mut window, "Cancel sharing");
    wait(&mut window, "a word about it", |window| shows(window, "Export stopped. Only the pictures"));
    assert!(window.query_by_label("Show in folder").is_none());
}

fn place(window: &Window) -> ([f64; 3], usize) {
    (window.state().observed().live_position.unwrap(), window.state().observed().frame)
}

/// Looks at something else, at another time.
fn go_away(window: &mut Window) {
    let before = place(window);
    drag(window, "Live picture", vec2(0.5, 0.5), vec2(-60.0, 25.0));
    window.key_press(Key::Period);
    window.run_steps(3);
    let after = place(window);
    assert!(before.0 != after.0 && before.1 != after.1);
}

#[test]
fn an_address_that_is_copied_leads_back_from_anywhere() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let path = save_store(&mut window, folder.path());
    let mut window = open(Start::Path(path.clone()), SIZE);
    wait(&mut window, "the store", |window| window.state().observed().scene_name.is_some());
    settle(&mut window);
    go_away(&mut window);
    click(&mut window, "Save");
    window.get_by_label("Copy the address of this view").click();
    let address = copied(&mut window).unwrap();
    let seen = place(&window);
    let start = format!("{}#view=", path.display());
    assert!(address.starts_with(&start) && address.contains(&format!("&frame={}", seen.1)), "{address}");

    go_away(&mut window);
    window.event(Event::Paste(address.clone()));
    window.run_steps(3);
    assert_eq!(place(&window), seen, "pasted");

    go_away(&mut window);
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(3);
    // As a page writes it, whose view it is of the same scene.
    let (_, view) = address.split_once('#').unwrap();
    window.get_by_label("Command").type_text(&format!("https://example.org/scene.html#{view}"));
    window.run_steps(3);
    click(&mut window, "Do: Go to this address");
    assert_eq!(place(&window), seen, "by the palette");

    let mut other = open(Start::Path(address.into()), SIZE);
    wait(&mut other, "the store", |window| window.state().observed().scene_name.is_some());
    settle(&mut other);
    assert_eq!(place(&other), seen, "opened");
}

#[test]
fn text_that_is_no_view_says_so_and_moves_nothing() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let before = place(&window);
    window.event(Event::Paste("scene.ovl#view=1,2,3".to_owned()));
    window.run_steps(3);
    assert!(told(&window, "Nothing to paste") && place(&window) == before);
}
