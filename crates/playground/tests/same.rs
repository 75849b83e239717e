//! The module says of every model what the same code says here: there are the same faces, edges
//! and vertices, and measures agree within their bounds. (Sines and cosines are another
//! library's, so that last digits differ.)
//!
//! Switched on by STEREOTOMY_WASM, as making the module takes some minutes; needs Node and the
//! compiler's target for WebAssembly (`build.sh`). With STEREOTOMY_CHROMIUM, the name of the
//! program, the playground is tried in a browser, too.
#![allow(missing_docs, reason = "a test")]

#[path = "../../view/web/tests/installed.rs"]
mod web;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use playground::Playground;
use serde_json::{Value, json};
use web::{installed, run};

#[test]
fn every_model_is_the_same() {
    if std::env::var_os("STEREOTOMY_WASM").is_none() {
        // (Not `println`, which is not seen where a test passes.)
        let said = "STEREOTOMY_WASM is not set: the playground is not tried";
        writeln!(std::io::stderr(), "{said}").expect("standard error");
        return;
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("playground");
    let web = installed();
    run(Command::new(here.join("build.sh"))
        .arg(&out)
        .env("PROFILE", "dev")
        .env("STEREOTOMY_WEB", &web));
    compare(here, &out);
    if let Ok(chromium) = std::env::var("STEREOTOMY_CHROMIUM") {
        run(Command::new("node")
            .args(["--test", "--test-reporter=spec", "tests/playground.test.js"])
            .current_dir(web)
            .env("PLAYGROUND", &out)
            .env("CHROMIUM", chromium));
    }
}

fn compare(here: &Path, out: &Path) {
    let scenes = scenes(&here.join("../../models"));
    assert!(scenes.len() > 50);
    let output = Command::new("node")
        .arg(here.join("tests/models.mjs"))
        .arg(here.join("../view/web/src/module.js"))
        .arg(out.join("playground.wasm"))
        .args(&scenes)
        .output()
        .expect("Node.js");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let lines = String::from_utf8(output.stdout).expect("UTF-8");
    let theirs: Vec<Value> = lines
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(theirs.len(), scenes.len());
    for (scene, theirs) in scenes.iter().zip(theirs) {
        let name = scene.display();
        let text = fs::read_to_string(scene).expect("a scene");
        let mut playground = Playground::default();
        let mut ask = |question: &Value| -> Value {
            let answer = playground.answer(question.to_string().as_bytes(), &mut |_| {});
            let bytes = answer.unwrap_or_else(|problem| panic!("{name}: {problem}"));
            serde_json::from_slice(&bytes).expect("JSON")
        };
        let problem = ask(&json!({ "ask": "make", "text": text }));
        assert_eq!(theirs["problem"], problem, "{name}");
        let (ours, theirs) = (ask(&json!({ "ask": "account" })), &theirs["account"]);
        let number = |account: &Value, field: &str| account[field].as_f64();
        let bound = |account| number(account, "volume_error").unwrap_or(f64::INFINITY);
        let volumes = [&ours, theirs].map(|account| number(account, "volume"));
        let [Some(one), Some(other)] = volumes else {
            panic!("{name}: {ours} and {theirs}");
        };
        let most = bound(&ours) + bound(theirs);
        assert!(most < 1e-3 * one, "{name}: no bound of {one}");
        assert!(
            (one - other).abs() <= most,
            "{name}: {one} and {other}, within {most}"
        );
        for label in ["bodies", "genus", "faces", "edges", "vertices"] {
            let count = |account: &Value| {
                let rows = account["measures"].as_array().expect("rows");
                let row = rows.iter().find(|row| row["label"] == label);
                row.and_then(|row| row["value"].as_f64())
            };
            assert!(count(&ours).is_some(), "{name}: {label}");
            assert_eq!(count(&ours), count(theirs), "{name}: {label}");
        }
    }
}

/// All scenes below a folder, by name.
fn scenes(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder of models");
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        if path.is_dir() {
            found.extend(scenes(&path));
        } else if path.extension().is_some_and(|extension| extension == "csg") {
            found.push(path);
        }
    }
    found
}
