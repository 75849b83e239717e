//! The module makes of every model what the same code makes here, to the byte: what is drawn, the
//! measures, and the files of all formats.
//!
//! Switched on by STEREOTOMY_WASM, as making the module takes a minute or more; needs Node and the
//! compiler's target for WebAssembly (`build.sh`). The module is compiled without optimisation, as
//! that takes half as long, and so it is asked about the models that the playground offers and some
//! of the others; with STEREOTOMY_WASM=whole it is optimised, and asked about all. With
//! STEREOTOMY_CHROMIUM, the name of the program, the playground is tried in a browser, too.
#![allow(missing_docs, reason = "a test")]

#[path = "../../view/web/tests/installed.rs"]
mod web;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use playground::Playground;
use serde_json::{Value, json};
use view::FORMATS;
use web::{installed, run};

/// Of the models in folders below, so many to one that is tried unless all are.
const MANY: usize = 8;

#[test]
fn models_are_the_same() {
    // (Not `println`, which is not seen where a test passes.)
    let say = |said: &str| writeln!(std::io::stderr(), "{said}").expect("standard error");
    let Some(asked) = std::env::var_os("STEREOTOMY_WASM") else {
        say("STEREOTOMY_WASM is not set: the playground is not tried");
        return;
    };
    let is_whole = asked == "whole";
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("playground");
    let web = installed();
    let mut build = Command::new(here.join("build.sh"));
    build
        .arg(&out)
        .env("PROFILE", std::env::var("PROFILE").unwrap_or("dev".into()))
        .env("STEREOTOMY_WEB", &web);
    if !is_whole {
        build.env("CARGO_PROFILE_DEV_OPT_LEVEL", "0");
    }
    run(&mut build);
    let all = scenes(&here.join("../../models"));
    assert!(all.len() > 50);
    let is_offered = |scene: &Path| scene.parent().is_some_and(|f| f.ends_with("models"));
    let tried = all
        .iter()
        .enumerate()
        .filter(|(number, scene)| is_whole || is_offered(scene) || number % MANY == 0)
        .map(|(_, scene)| scene.clone());
    let tried: Vec<PathBuf> = tried.collect();
    if !is_whole {
        let (some, all) = (tried.len(), all.len());
        say(&format!(
            "{some} of {all} models: all with STEREOTOMY_WASM=whole"
        ));
    }
    compare(here, &out, &tried);
    if let Ok(chromium) = std::env::var("STEREOTOMY_CHROMIUM") {
        run(Command::new("node")
            .args(["--test", "--test-reporter=spec", "tests/playground.test.js"])
            .current_dir(web)
            .env("PLAYGROUND", &out)
            .env("CHROMIUM", chromium));
    }
}

fn compare(here: &Path, out: &Path, scenes: &[PathBuf]) {
    let node = Command::new("node")
        .arg(here.join("tests/models.mjs"))
        .arg(here.join("../view/web/src/module.js"))
        .arg(out.join("playground.wasm"))
        .arg(FORMATS.join(","))
        .args(scenes)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("Node.js");
    // What is said here, while it is said there.
    let ours = scenes.iter().enumerate().map(|(number, scene)| {
        let text = fs::read_to_string(scene).expect("a scene");
        timeless(said(number, &text))
    });
    let there = std::thread::spawn(|| node.wait_with_output());
    let ours: Vec<Value> = ours.collect();
    let output = there.join().expect("no panic").expect("Node.js");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let lines = String::from_utf8(output.stdout).expect("UTF-8");
    let theirs: Vec<Value> = lines
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(theirs.len(), scenes.len());
    let mut different = Vec::new();
    for ((scene, ours), theirs) in scenes.iter().zip(ours).zip(theirs) {
        let read = |part: &Value| {
            let text = part.as_str().expect("text");
            serde_json::from_str(text).unwrap_or_else(|_| part.clone())
        };
        let mut theirs = theirs;
        for part in ["problem", "account"] {
            theirs[part] = read(&theirs[part]);
        }
        let theirs = timeless(theirs);
        for part in ["problem", "account", "drawn", "files"] {
            if ours[part] != theirs[part] {
                let (ours, theirs) = (&ours[part], &theirs[part]);
                different.push(format!(
                    "{}: {part}:\n  {ours}\n  {theirs}",
                    scene.display()
                ));
            }
        }
        assert_eq!(ours["problem"], Value::Null, "{}", scene.display());
        assert!(ours["account"]["volume"].as_f64() > Some(0.0));
    }
    let (count, different) = (different.len(), different.join("\n"));
    assert_eq!(count, 0, "here and as WebAssembly:\n{different}");
}

/// What `models.mjs` says of a scene, by the code as it is here.
fn said(number: usize, text: &str) -> Value {
    let mut playground = Playground::default();
    let mut drawn = Vec::new();
    let mut ask = |question: &Value| {
        let publish = &mut |bytes: &[u8]| drawn.push(sum(bytes));
        playground.answer(question.to_string().as_bytes(), publish)
    };
    let json = |answer: Result<Vec<u8>, String>| match answer {
        Ok(bytes) => serde_json::from_slice(&bytes).expect("JSON"),
        Err(problem) => Value::String(problem),
    };
    let problem = json(ask(&json!({ "ask": "make", "text": text })));
    let account = json(ask(&json!({ "ask": "account" })));
    let files: Vec<String> = FORMATS
        .iter()
        .map(|format| {
            let file = ask(&json!({ "ask": "file", "format": format }));
            if let (Ok(bytes), Some(folder)) = (&file, std::env::var_os("KEEP")) {
                let path = PathBuf::from(folder).join(format!("{number}.{format}"));
                fs::write(path.with_extension(format!("ours.{format}")), bytes).expect("a file");
            }
            file.map_or_else(|problem| problem, |bytes| sum(&bytes))
        })
        .collect();
    json!({ "problem": problem, "account": account, "drawn": drawn, "files": files })
}

/// Without how long it took.
fn timeless(mut said: Value) -> Value {
    if let Some(rows) = said["account"]["report"].as_array_mut() {
        rows.retain(|row| row["label"] != "meshing took");
    }
    said
}

/// Length and FNV-1a of bytes.
fn sum(bytes: &[u8]) -> String {
    let hash = bytes.iter().fold(0x811c_9dc5_u32, |hash, &byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    });
    format!("{} bytes, {hash:x}", bytes.len())
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
