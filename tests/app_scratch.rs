#![allow(warnings)]
mod app_driver;
use app_driver::*;
use egui_kittest::kittest::Queryable;
fn shot(w: &mut Window, name: &str) {
    w.run_steps(3);
    w.render().unwrap().save(format!("/tmp/scratch_{name}.png")).unwrap();
}
#[test]
fn scratch() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("orrery.ovl");
    let mut w = open(demo(5, 6, (320, 240)), [1280.0, 800.0]);
    settle(&mut w);
    let t = std::time::Instant::now();
    for _ in 0..60 {
        w.step();
    }
    println!("STEP ms {}", t.elapsed().as_secs_f64() * 1e3 / 60.0);
    choose(&mut w, "Source shows", "Who won");
    settle(&mut w);
    w.hover_at(w.get_by_label("Source picture").rect().center() + egui::vec2(30.0, 60.0));
    shot(&mut w, "hover");
    w.remove_cursor();
    pick(&mut w, "Pruning method", "First camera");
    for _ in 0..20 {
        w.step();
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    shot(&mut w, "stale");
    settle(&mut w);
    type_path(&mut w, "Save", "Save store to path…", &path, "Save this path");
    wait(&mut w, "file", |w| w.state().notices().len() > 0);
    shot(&mut w, "saved");
    click(&mut w, "Open");
    click(&mut w, "Open path…");
    shot(&mut w, "path");
    w.get_by_label("Path").set_text_value_accesskit(&path.display().to_string());
    w.run_steps(3);
    click(&mut w, "Open this path");
    wait(&mut w, "store", |w| shows(w, "holds no source"));
    settle(&mut w);
    click(&mut w, "Report");
    shot(&mut w, "store");
    click(&mut w, "Open");
    shot(&mut w, "menu");
    w.key_press(egui::Key::Escape);
    w.run_steps(2);
    w.set_size(egui::vec2(960.0, 600.0));
    click(&mut w, "Thresholds");
    settle(&mut w);
    shot(&mut w, "small");
    pick(&mut w, "Go to camera", "high");
    settle(&mut w);
    for _ in 0..30 {
        w.get_by_label("Live picture").scroll_down();
        w.run_steps(2);
    }
    settle(&mut w);
    shot(&mut w, "frusta");
}
