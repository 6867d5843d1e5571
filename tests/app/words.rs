//! The window speaks in the terms of the field: those are on the screen, and none of its own.

use egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

use super::driver::{SIZE, Window, choose, click, fold, look_at, open, open_view, settle, shows, small_demo};
use super::private_words::private_word;

fn assert_no_private_word(window: &Window, place: &str) {
    let mut texts = 0;
    for node in window.query_all_by_label_contains("") {
        let node = node.accesskit_node();
        for text in [node.label(), node.value()].into_iter().flatten() {
            texts += 1;
            assert_eq!(private_word(&text), None, "{place}: {text}");
        }
    }
    assert!(texts > 40, "{place}: {texts} texts were read");
}

fn assert_says(window: &Window, place: &str, words: &[&str]) {
    for word in words {
        assert!(shows(window, word), "{place} does not say {word:?}");
    }
    assert_no_private_word(window, place);
}

#[test]
fn every_view_calls_things_as_the_field_does() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    assert_says(
        &window,
        "The window",
        &["Kept by", "dB vs unpruned", "time-varying samples", "This frame: ", "drawn", "No pixel selected"],
    );
    look_at(&mut window, "Source picture", vec2(0.5, 0.6));
    settle(&mut window);
    let table = ["Visible", "Depth error", "Density", "Its own sample"];
    assert_says(&window, "Pixel", &table);
    assert!(window.query_by_label("Unpin pixel").is_some());
    for (view, words) in [
        ("Compare", &["PSNR ", "covered on one side only"][..]),
        ("Time", &["Samples by the span of frames"]),
        (
            "Report",
            &[
                "What was dropped, and why",
                "Seen better elsewhere",
                "of samples in memory, by camera",
                "a time offset shows here",
            ],
        ),
        ("Sweep", &["No sweep yet"]),
        ("Stress test", &["No stress test yet"]),
        ("View", &["Field of view", "focal length"]),
        ("Color", &["Exposure", "Tone curve and channel"]),
    ] {
        open_view(&mut window, view);
        // Over pictures the pointer asks for a pixel.
        window.hover_at(egui::pos2(5.0, 5.0));
        settle(&mut window);
        assert_says(&window, view, words);
    }
    open_view(&mut window, "Compare");
    choose(&mut window, "Compare by", "Difference");
    for measure in ["Absolute", "Signed", "FLIP"] {
        assert!(window.query_by_label(&format!("Difference in: {measure}")).is_some(), "{measure}");
    }
    open_view(&mut window, "Camera path");
    window.key_press(Key::K);
    window.run_steps(3);
    assert_says(&window, "Camera path", &["Frames per segment"]);
}

#[test]
fn settings_and_presets_have_the_names_of_the_field() {
    // Tall enough for the last of the settings.
    let mut window = open(small_demo(), [SIZE[0], 2100.0]);
    settle(&mut window);
    for section in ["Temporal redundancy", "Rendering", "Store encoding", "Loading"] {
        assert!(window.query_by_label(section).is_some(), "{section}");
    }
    fold(&mut window, "Advanced");
    for setting in [
        "Time spans",
        "Noise multiplier",
        "Minimum cos θ",
        "Match static with moving",
        "Keep 1-px overlap",
        "Edge-blended pixels",
        "Hole filling",
    ] {
        let named = window.query_all_by_label(setting).count();
        assert_eq!(named, 1, "{setting}: one control has this name");
    }
    assert_no_private_word(&window, "Settings");
    for (list, choices) in [
        ("Hole filling", &["None", "Push-pull"][..]),
        ("Kernel", &["Gather (interpolate cameras)"]),
        ("Renderer", &["CPU", "GPU"]),
        ("Presets", &["Conservative", "Aggressive", "Load settings…", "Save settings…"]),
    ] {
        click(&mut window, list);
        assert_says(&window, list, choices);
        window.key_press(Key::Escape);
        window.run_steps(3);
    }
}

#[test]
fn the_palette_names_what_it_does_as_other_programs_do() {
    // As high as all entries that one word finds.
    let mut window = open(small_demo(), [SIZE[0], 1000.0]);
    settle(&mut window);
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(3);
    assert_no_private_word(&window, "The palette");
    for (typed, entry) in [
        ("undo", "Undo"),
        ("redo", "Redo"),
        ("recompute", "Recompute the whole capture"),
        ("copy expl", "Copy explanation"),
        ("reset view", "Reset view to start"),
        ("center", "Center view on the selection, or the selected pixel"),
        ("video", "Share: Video"),
        ("shortcuts", "Keyboard and mouse shortcuts"),
        ("stress", "Run a stress test"),
    ] {
        window.get_by_label("Command").replace_selected_text_accesskit("");
        window.get_by_label("Command").set_text_value_accesskit(typed);
        window.run_steps(3);
        assert!(window.query_by_label(&format!("Do: {entry}")).is_some(), "{typed} does not find {entry:?}");
        assert_no_private_word(&window, typed);
    }
}
