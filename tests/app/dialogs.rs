//! What lies over the window and what names cameras: no tooltip above a dialog, no camera that reads as a word of a sentence.

use egui::{Key, Modifiers, Rect, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use overlook::app::Start;
use overlook_engine::demo::DemoSpec;

use super::driver::{SIZE, Window, click, look_at, open, settle, shows, small_demo};

const TOOLTIP: &str = "Find any command by name (Ctrl+P)";

/// Rests on a button until what it explains is there.
fn rest_on(window: &mut Window, button: &str) {
    let at = window.get_by_label(button).rect().center();
    window.hover_at(at);
    for _ in 0..20 {
        window.step();
    }
}

#[test]
fn a_tooltip_goes_where_a_dialog_opens_and_comes_back_after_it() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    rest_on(&mut window, "Commands");
    assert!(shows(&window, TOOLTIP));
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(8);
    assert!(window.query_by_label("Command").is_some(), "the palette is open");
    assert!(!shows(&window, TOOLTIP), "nothing lies above it");
    window.key_press(Key::Escape);
    window.run_steps(3);
    // Menus and questions are dialogs as well.
    rest_on(&mut window, "Commands");
    window.key_press(Key::Questionmark);
    window.run_steps(8);
    assert!(window.query_by_label("Close help").is_some() && !shows(&window, TOOLTIP));
    click(&mut window, "Close help");
    window.hover_at(egui::pos2(SIZE[0] / 2.0, 12.0));
    window.run_steps(4);
    rest_on(&mut window, "Commands");
    assert!(shows(&window, TOOLTIP), "it explains again");
}

#[test]
fn the_sheet_of_shortcuts_fits_into_a_low_window_with_its_button() {
    for size in [SIZE, [1024.0, 640.0]] {
        let mut window = open(small_demo(), size);
        settle(&mut window);
        window.key_press(Key::Questionmark);
        window.run_steps(8);
        let title = window.get_by_label("Keyboard and mouse shortcuts").rect();
        let button = window.get_by_label("Close help").rect();
        assert!(title.top() >= 0.0 && button.bottom() <= size[1], "{title} {button}");
        click(&mut window, "Close help");
        assert!(window.query_by_label("Close help").is_none());
    }
}

#[test]
fn the_first_line_of_a_tooltip_begins_where_the_others_do() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    rest_on(&mut window, "Commands");
    let text = window.get_by_label_contains(TOOLTIP).rect();
    let picture = window.render().unwrap();
    let background = picture.get_pixel(text.left() as u32 - 3, text.center().y as u32);
    let is_text = |x: u32, y: u32| {
        let apart = picture.get_pixel(x, y).0.iter().zip(background.0).map(|(a, b)| a.abs_diff(b)).max();
        apart.unwrap_or(0) > 60
    };
    let rows = || text.top() as u32..text.bottom() as u32;
    let first = (text.left() as u32 - 2..text.right() as u32).find(|x| rows().any(|y| is_text(*x, y)));
    assert!(first.unwrap() <= text.left() as u32 + 2, "{first:?} {text}");
}

#[test]
fn what_a_histogram_tells_covers_no_other_histogram() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let histogram = "Depth tolerance on its histogram";
    rest_on(&mut window, histogram);
    let told = window.query_all_by_label_contains(" within the line, ").map(|text| text.rect());
    let told = told.reduce(Rect::union).expect("it is explained");
    let histograms = window.query_all_by_label_contains("on its histogram");
    let covered = histograms.filter(|other| other.rect().intersect(told).is_positive()).count();
    assert_eq!(covered, 0, "{told} lies beside {}", window.get_by_label(histogram).rect());
}

#[test]
fn the_cells_of_a_row_of_the_pixel_table_stand_on_one_middle() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    look_at(&mut window, "Source picture", vec2(0.5, 0.6));
    settle(&mut window);
    let rows: Vec<f32> = window
        .query_all_by_label_contains("Go to the point in ")
        .map(|name| name.rect().center().y)
        .collect();
    let (first, last) = (rows[0] - 10.0, rows[rows.len() - 1] + 10.0);
    let mut cells = 0;
    for cell in window.query_all_by_label_contains("°") {
        let text = cell.accesskit_node().value().or_else(|| cell.accesskit_node().label());
        let middle = cell.rect().center().y;
        if text.is_some_and(|text| text.chars().count() <= 3) && (first..last).contains(&middle) {
            cells += 1;
            assert!(rows.iter().any(|row| (row - middle).abs() < 1.1), "{middle} {rows:?}");
        }
    }
    assert!(cells > 0, "some camera sees the point at an angle");
}

/// Pixels of a color, not gray, in a part of the window.
fn colored(window: &mut Window, area: Rect) -> usize {
    let picture = window.render().unwrap();
    let (xs, ys) = (area.left() as u32..area.right() as u32, area.top() as u32..area.bottom() as u32);
    let all = ys.flat_map(|y| xs.clone().map(move |x| (x, y)));
    all.filter(|(x, y)| {
        let [r, g, b, _] = picture.get_pixel(*x, *y).0;
        r.max(g).max(b) - r.min(g).min(b) > 70
    })
    .count()
}

#[test]
fn a_camera_called_by_a_word_stands_out_from_the_sentence_that_names_it() {
    let mut window = open(Start::Demo(DemoSpec::new("orrery").cameras(4).frames(1).size((96, 72))), SIZE);
    settle(&mut window);
    let names = ["front", "left", "right", "close", "above", "high"];
    let mut sentences = 0;
    for at in [vec2(0.5, 0.55), vec2(0.35, 0.7), vec2(0.65, 0.4), vec2(0.2, 0.3)] {
        look_at(&mut window, "Source picture", at);
        settle(&mut window);
        let texts: Vec<(String, Rect)> = window
            .query_all_by_label_contains(" ")
            .filter_map(|node| {
                let text = node.accesskit_node().value().or_else(|| node.accesskit_node().label())?;
                let area = node.accesskit_node().bounding_box()?;
                let corner = |x, y| egui::pos2(x as f32, y as f32);
                Some((text, Rect::from_min_max(corner(area.x0, area.y0), corner(area.x1, area.y1))))
            })
            .collect();
        for (text, area) in texts {
            let words: Vec<&str> = text.split([' ', ',', '.', ':', ';']).collect();
            let names_camera = words.len() > 4 && words.iter().any(|word| names.contains(word));
            // What starts with a camera's name is about it, as in a row of a table.
            let is_verdict = text.starts_with("Dropped") || text.starts_with("Kept");
            if names_camera && is_verdict && area.height() > 4.0 {
                sentences += 1;
                assert!(colored(&mut window, area) > 60, "{text}");
            }
        }
    }
    assert!(sentences > 0, "some verdict names a camera");
}
