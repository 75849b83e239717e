//! Questions to Open CASCADE.

use std::io::{BufRead, BufReader, Write};
use std::ops::{Deref, DerefMut};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::{Mutex, PoisonError};

use serde_json::{Value, json};

/// What was read of a STEP file.
pub struct Read {
    pub is_valid: bool,
    pub is_closed: bool,
    pub products: Vec<String>,
    /// What these are put together from, each as `outer/inner`.
    pub parts: Vec<String>,
    pub solids: Vec<Body>,
    pub faces: Vec<Face>,
    /// With images of edges on surfaces through more points than the reader's own.
    pub volume: f64,
}

pub struct Body {
    pub name: String,
    pub shells: usize,
    pub color: Option<[f64; 3]>,
}

pub struct Face {
    pub name: String,
    pub color: Option<[f64; 3]>,
}

/// `occ.py`, running: it answers one line of JSON by another.
pub struct Script {
    child: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
}

/// Those that no test asks at the moment: to load Open CASCADE takes two seconds.
static IDLE: Mutex<Vec<Script>> = Mutex::new(Vec::new());

/// One that is asked by one test alone, and left to others where that passes.
pub struct Lent(Option<Script>);

impl Lent {
    /// One that is idle, or else another one, which a function starts.
    pub fn or_start(start: impl FnOnce() -> Script) -> Self {
        let idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Self(Some(idle.unwrap_or_else(start)))
    }
}

impl Deref for Lent {
    type Target = Script;

    fn deref(&self) -> &Script {
        self.0.as_ref().expect("lent until it is dropped")
    }
}

impl DerefMut for Lent {
    fn deref_mut(&mut self) -> &mut Script {
        self.0.as_mut().expect("lent until it is dropped")
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        // Amid a question its answers would be another test's.
        if !std::thread::panicking() {
            let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
            idle.extend(self.0.take());
        }
    }
}

impl Script {
    /// By a Python with the packages of `requirements.txt`.
    pub fn start(python: &Path) -> Self {
        let mut child = Command::new(python)
            .args(["-c", include_str!("occ.py")])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit())
            .spawn()
            .unwrap_or_else(|error| panic!("{} does not run: {error}", python.display()));
        Self {
            questions: child.stdin.take().expect("its input"),
            answers: BufReader::new(child.stdout.take().expect("its output")),
            child,
        }
    }

    /// Reads a STEP file, and the names and colours of faces if asked to.
    pub fn read(&mut self, path: &Path, of_faces: bool) -> Read {
        let question = json!({ "path": path, "of_faces": of_faces });
        writeln!(self.questions, "{question}").expect("the script reads");
        let mut line = String::new();
        self.answers
            .read_line(&mut line)
            .expect("the script writes");
        let said: Value = serde_json::from_str(&line)
            .unwrap_or_else(|_| panic!("the script gave up on {}", path.display()));
        assert!(said["problem"].is_null(), "{}", said["problem"]);
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let all = |name: &str| said[name].as_array().expect("a list").clone();
        Read {
            is_valid: said["valid"].as_bool().expect("a verdict"),
            is_closed: said["closed"].as_bool().expect("a verdict"),
            products: all("products").iter().map(text).collect(),
            parts: all("parts").iter().map(text).collect(),
            solids: all("solids")
                .iter()
                .map(|solid| Body {
                    name: text(&solid["name"]),
                    shells: solid["shells"].as_u64().expect("a number") as usize,
                    color: color(&solid["color"]),
                })
                .collect(),
            faces: all("faces")
                .iter()
                .map(|face| Face {
                    name: text(&face["name"]),
                    color: color(&face["color"]),
                })
                .collect(),
            volume: said["volume"].as_f64().expect("a number"),
        }
    }
}

fn color(value: &Value) -> Option<[f64; 3]> {
    let rgb = value.as_array()?;
    let rgb: Vec<f64> = rgb.iter().filter_map(Value::as_f64).collect();
    rgb.try_into().ok()
}

impl Drop for Script {
    fn drop(&mut self) {
        // It only waits for more questions. (Those that are idle at the end are not dropped, but
        // read that there will be none.)
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
