//! What views show in numbers leaves the window as text.

use egui_kittest::kittest::{NodeT, Queryable};

use super::driver::{
    SIZE, Window, choose, click, copied, copy_table, demo, look_at, measure, open, open_view, pick, settle,
    shows, small_demo, wait,
};
use super::layout_faults::faults;
use egui::{Key, vec2};

/// Copies a table of a view, and gives the lines that it leaves on the clipboard.
fn copied_table(window: &mut Window, view: &str, name: &str) -> Vec<String> {
    copy_table(window, view, "CSV", name);
    let text = copied(window).unwrap_or_else(|| panic!("{name}: nothing was copied"));
    assert!(shows(window, &format!("The {name} is on the clipboard as CSV.")), "{name}");
    // The message lies over the lower panel.
    window.key_press(Key::Escape);
    window.run_steps(2);
    text.lines().map(str::to_owned).collect()
}

#[test]
fn the_tables_of_pixel_matrix_and_cameras_are_copied_with_a_line_of_names() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    look_at(&mut window, "Source picture", vec2(0.5, 0.6));
    settle(&mut window);
    let pixel = copied_table(&mut window, "Pixel", "pixel table");
    assert!(pixel[0].starts_with("camera,visible,depth_expected,") && pixel.len() == 4, "{pixel:?}");
    open_view(&mut window, "Report");
    let replaced = copied_table(&mut window, "Report", "matrix of replaced samples");
    assert_eq!(replaced[0], "camera,replaced_by,samples");
    assert_eq!(replaced.len(), 1 + 3 * 2, "{replaced:?}");
    let agreement = copied_table(&mut window, "Report", "matrix of agreement");
    assert!(agreement[0].starts_with("camera,against,what,samples,"), "{agreement:?}");
    assert!(agreement.iter().any(|line| line.starts_with("front,left,static,")), "{agreement:?}");
    let memory = copied_table(&mut window, "Report", "memory table");
    assert_eq!(memory[0], "camera,samples,bytes_of_several_frames,bytes_of_one_frame,bytes");
    assert_eq!(memory.len(), 4, "{memory:?}");
    open_view(&mut window, "Time");
    let spans = copied_table(&mut window, "Time", "span table");
    assert_eq!(spans[0], "first_frame,last_frame,frames,samples");
    assert!(spans.len() > 1 && spans.iter().skip(1).all(|line| line.split(',').count() == 4), "{spans:?}");
    open_view(&mut window, "Report");
    let cameras = copied_table(&mut window, "Report", "camera table");
    assert!(cameras[0].starts_with("camera,pixels,kept,") && cameras.len() == 4, "{cameras:?}");
}

/// Measures a point of a sweep and stops.
fn with_a_point() -> Window {
    let mut window = open(demo(2, 1, (32, 24)), SIZE);
    settle(&mut window);
    open_view(&mut window, "Sweep");
    measure(&mut window, "Run a sweep…");
    wait(&mut window, "a point", |window| {
        shows(window, "click one to apply it") || shows(window, "click it")
    });
    window.key_press(Key::Escape);
    settle(&mut window);
    window
}

#[test]
fn a_sweep_is_copied() {
    let mut window = with_a_point();
    let sweep = copied_table(&mut window, "Sweep", "sweep");
    assert!(sweep[0].starts_with("label,series,kernel,psnr_filled_db,") && sweep.len() > 1, "{sweep:?}");
    click(&mut window, "Export Sweep");
    click(&mut window, "Copy the sweep chart");
    wait(&mut window, "the chart", |window| shows(window, "The sweep chart is on the clipboard"));
}

#[test]
fn series_are_left_out_by_their_entries_in_the_legend_and_axes_change_their_scale() {
    let mut window = with_a_point();
    let is_on = |window: &Window, entry: &str| {
        window.get_by_label(entry).accesskit_node().toggled() == Some(egui::accesskit::Toggled::True)
    };
    let points = |window: &Window| -> usize {
        let hint = window.query_all_by_label_contains("to apply it").next().unwrap();
        let hint = hint.accesskit_node().value().unwrap();
        hint.split(' ').next().unwrap().parse().unwrap()
    };
    let series = "your settings";
    let all = points(&window);
    assert!(is_on(&window, series) && !shows(&window, "left out"));
    click(&mut window, series);
    assert!(!is_on(&window, series) && points(&window) < all);
    open_view(&mut window, "Report");
    open_view(&mut window, "Sweep");
    assert!(!is_on(&window, series), "it is remembered");
    window.get_by_label(series).focus();
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert!(is_on(&window, series) && points(&window) == all);

    let scale = "X axis: logarithmic";
    let is_chosen = |window: &Window| {
        let toggled = window.get_by_label(scale).accesskit_node().toggled();
        toggled == Some(egui::accesskit::Toggled::True)
    };
    assert!(is_chosen(&window));
    click(&mut window, scale);
    assert!(!is_chosen(&window));
    assert!(window.query_by_label("Y axis: logarithmic").is_none(), "decibels are logarithms already");
    pick(&mut window, "X axis", "Samples");
    assert!(is_chosen(&window), "another quantity has its own scale");
}

/// Texts that are cut off. Those of a dialog lie over others.
fn cut_off(window: &Window) -> Vec<String> {
    faults(window).into_iter().filter(|fault| fault.contains("is cut off by")).collect()
}

#[test]
fn at_the_usual_size_no_button_above_a_chart_is_cut_and_nothing_covers_the_legend() {
    for size in [SIZE, [1024.0, 640.0]] {
        let mut window = open(demo(2, 1, (32, 24)), size);
        settle(&mut window);
        open_view(&mut window, "Sweep");
        measure(&mut window, "Run a sweep…");
        wait(&mut window, "a point", |window| shows(window, "click it") || shows(window, "click one"));
        window.key_press(Key::Escape);
        settle(&mut window);
        assert_eq!(cut_off(&window), Vec::<String>::new(), "{size:?}");
        let chart = window.get_by_label("Sweep chart").rect();
        for name in ["Run a sweep…", "Export Sweep"] {
            let button = window.get_by_label(name).rect();
            assert!(button.width() > 30.0 && button.height() < 34.0, "{name} at {size:?}: {button}");
            assert!(button.bottom() <= chart.top(), "{name} at {size:?}: {button}, {chart}");
        }
        assert!(window.get_by_label("Pareto front").rect().bottom() <= chart.top() + 1.0);
    }
}

#[test]
fn what_is_measured_is_chosen_first_with_how_much_that_is() {
    let mut window = open(demo(2, 1, (32, 24)), SIZE);
    settle(&mut window);
    open_view(&mut window, "Stress test");
    click(&mut window, "Run a stress test…");
    let counted = |window: &Window| -> usize {
        let line = window.query_all_by_label_contains("how long is unknown").next().unwrap();
        line.accesskit_node()
            .value()
            .or(line.accesskit_node().label())
            .unwrap()
            .split(' ')
            .next()
            .unwrap()
            .parse()
            .unwrap()
    };
    let quick = counted(&window);
    choose(&mut window, "Amount", "Full");
    let all = counted(&window);
    assert!(quick < all && window.query_by_label("Values: Coarse").is_none(), "{quick} of {all}");
    choose(&mut window, "Amount", "Choose…");
    // The dialog takes its place with all that can be chosen.
    window.run_steps(4);
    click(&mut window, "Values: Coarse");
    let coarse = counted(&window);
    assert!(coarse < all && cut_off(&window).is_empty(), "{coarse} of {all}, {:?}", cut_off(&window));
    for group in ["disturbances", "methods"] {
        click(&mut window, &format!("No {group}"));
    }
    assert!(shows(&window, "Nothing is left to measure"));
    click(&mut window, "Camera pose");
    click(&mut window, "Your settings");
    assert_eq!(counted(&window), 2, "both ends of one dial with one method");
    choose(&mut window, "Time", "Until done");
    click(&mut window, "Start measuring");
    settle(&mut window);
    assert!(window.query_by_label("Start measuring").is_none() && window.query_by_label("Resume").is_none());
    let table = copied_table(&mut window, "Stress test", "stress test");
    assert_eq!(table.len(), 3, "{table:?}");

    // Zero has no place on a logarithmic axis.
    click(&mut window, "Disturbance axis: logarithmic");
    assert!(shows(&window, "1 point left out"));
    click(&mut window, "Run a stress test…");
    assert!(shows(&window, "Nothing is left to measure"), "both are known");
    click(&mut window, "Values: Fine");
    assert!(shows(&window, "about ") && !shows(&window, "unknown"));
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(window.query_by_label("Start measuring").is_none());
}

/// What the cross in the window's corner does.
fn close(window: &mut Window) {
    let viewport = window.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
    viewport.events.push(egui::ViewportEvent::Close);
    window.run_steps(3);
}

#[test]
fn a_sweep_that_would_be_lost_can_be_saved_from_the_question() {
    let mut window = with_a_point();
    close(&mut window);
    assert!(shows(&window, "This would be lost: the sweep ("));
    for choice in ["Save sweep…", "Discard and close", "Cancel closing"] {
        assert!(window.query_by_label(choice).is_some(), "{choice}");
    }
    click(&mut window, "Cancel closing");
    assert!(!shows(&window, "This would be lost") && window.query_by_label("Sweep chart").is_some());
}
