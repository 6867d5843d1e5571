//! Sweeps and stress tests cut by what they try: once their journals are put together, nothing is left to measure, and all of it gives
//! the results of one piece.
#![cfg(unix)]

use std::path::Path;
use std::process::{Command, Output};

use crate::command::scene;
use crate::said::succeed;
use serde_json::Value;

/// Runs the script of `assets/cluster` that puts journals together.
fn join_journals(folder: &Path, journals: &[&str]) -> Output {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cluster/join_journals.sh");
    Command::new("sh").arg(script).args(journals).current_dir(folder).output().unwrap()
}

/// A document without what depends on a clock, and on what was compared by it.
fn timeless(mut document: Value) -> Value {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(map) => {
                map.retain(|key, _| {
                    ![
                        "milliseconds",
                        "milliseconds_se",
                        "seconds_preprocess",
                        "load_of_others",
                        "pareto",
                        "peak",
                    ]
                    .contains(&key.as_str())
                });
                map.values_mut().for_each(strip);
            }
            Value::Array(list) => list.iter_mut().for_each(strip),
            _ => {}
        }
    }
    strip(&mut document);
    document
}

/// Puts the journals of the jobs `out/1` and `out/2` together, and runs all of their work with the joined journal and without.
fn is_as_in_one_piece(folder: &Path, study: &str, whole: &[&str]) {
    let journal = folder.join("out").join(format!("{study}.journal"));
    let document = || -> Value {
        let text = std::fs::read_to_string(folder.join("out").join(format!("{study}.json"))).unwrap();
        timeless(serde_json::from_str(&text).unwrap())
    };
    let jobs = [1, 2].map(|job| format!("out/{job}/{study}.journal"));
    let joined = join_journals(folder, &jobs.each_ref().map(String::as_str));
    assert!(joined.status.success(), "{}", String::from_utf8_lossy(&joined.stderr));
    std::fs::write(&journal, &joined.stdout).unwrap();
    succeed(folder, whole);
    assert!(std::fs::read(&journal).unwrap() == joined.stdout, "something was measured again");
    let in_jobs = document();
    std::fs::remove_file(&journal).unwrap();
    succeed(folder, whole);
    assert_eq!(in_jobs, document());
}

#[test]
fn sweeps_of_one_value_each_are_the_sweep_of_all_once_their_journals_are_put_together() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    let sweep = |out, values| ["sweep", "scene", "--kernel", "block", "--out", out, "--vary", values];
    succeed(folder, &sweep("out/1", "pruning.depth_tolerance=0.5"));
    std::fs::create_dir(folder.join("out/2")).unwrap();
    std::fs::copy(folder.join("out/1/sweep.journal"), folder.join("out/2/sweep.journal")).unwrap();
    succeed(folder, &sweep("out/2", "pruning.depth_tolerance=2"));
    let [first, second] = [1, 2].map(|job| {
        let text = std::fs::read_to_string(folder.join(format!("out/{job}/sweep.journal"))).unwrap();
        text.lines().count()
    });
    assert_eq!(second, first + 1, "the second measures its own value alone");
    is_as_in_one_piece(folder, "sweep", &sweep("out", "pruning.depth_tolerance=0.5,2"));
}

#[test]
fn stress_tests_of_one_disturbance_each_are_that_of_all_once_their_journals_are_put_together() {
    let folder = scene("1", "48x36");
    let folder = folder.path();
    let stress = |out: &'static str, only: &[&'static str]| {
        let only = only.iter().flat_map(|name| ["--only", *name]);
        ["stress", "scene", "--set", "render.kernel=block", "--out", out].into_iter().chain(only).collect()
    };
    let [first, second, all]: [Vec<&str>; 3] = [
        stress("out/1", &["camera pose"]),
        stress("out/2", &["depth noise"]),
        stress("out", &["camera pose", "depth noise"]),
    ];
    succeed(folder, &first);
    succeed(folder, &second);
    is_as_in_one_piece(folder, "stress", &all);
}

#[test]
fn a_journal_of_another_state_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, text) in [("a", "\"now\"\n1\n"), ("b", "\"now\"\n2\n3\n"), ("c", "\"before\"\n4\n")] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    assert_eq!(join_journals(folder, &["a", "b"]).stdout, b"\"now\"\n1\n2\n3\n");
    let refused = join_journals(folder, &["a", "b", "c"]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(!refused.status.success() && said.starts_with("c: was measured on another state"), "{said}");
    assert!(!join_journals(folder, &["a", "missing"]).status.success());
}
