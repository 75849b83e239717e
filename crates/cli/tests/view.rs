//! `csg view` as others see it: who may ask what, and the page in a real browser.
//!
//! The browser is switched on by STEREOTOMY_CHROMIUM, the name of the program (Debian:
//! chromium); off, the test says so and does nothing more. Node with npm installs what the page
//! is made and tested with, once, under the target folder.
#![allow(missing_docs, reason = "a test")]

#[path = "../../view/web/tests/installed.rs"]
mod web;

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpStream, UdpSocket};
use std::path::Path;
use std::process::{Child, Command, ExitCode, Stdio};

use cli::clap;
use csg::Solid;

use web::{installed, run};

/// What makes this program the model of [`model`].
const MODEL: &str = "STEREOTOMY_VIEW_MODEL";

fn main() -> ExitCode {
    if std::env::var_os(MODEL).is_some() {
        return model();
    }
    only_the_page_is_answered();
    println!("view: only the page is answered");
    let web = installed();
    the_script_is_what_its_sources_make(&web);
    println!("view: the script is what its sources make");
    match std::env::var("STEREOTOMY_CHROMIUM") {
        Ok(chromium) => in_a_browser(&web, &chromium),
        Err(_) => println!("view: STEREOTOMY_CHROMIUM is not set: not tried in a browser"),
    }
    ExitCode::SUCCESS
}

#[derive(clap::Args)]
struct Arguments {
    /// Radius of the bore
    #[arg(long, default_value_t = 1.0, value_parser = radius)]
    radius: f64,
    /// Without the bore
    #[arg(long)]
    solid: bool,
}

fn radius(text: &str) -> Result<f64, String> {
    let radius = text.parse().ok().filter(|&radius| radius > 0.0);
    radius.ok_or_else(|| "give a radius above 0".to_owned())
}

/// A cube of side 10 with a bore.
fn model() -> ExitCode {
    cli::run_with(|Arguments { radius, solid }: Arguments| {
        assert!(radius < 3.0, "too wide");
        let cube = Solid::cube(10.0);
        if solid {
            cube
        } else {
            cube - Solid::infinite_cylinder(radius)
        }
    })
}

/// A page that is served as long as this lives.
struct Served {
    program: Child,
    at: SocketAddr,
    token: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        self.program.kill().expect("a program that can be ended");
        self.program.wait().expect("its end");
    }
}

impl Served {
    fn new() -> Self {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/flange.csg");
        let mut program = Command::new(env!("CARGO_BIN_EXE_csg"))
            .args(["view", "--no-open"])
            .arg(scene)
            .stdout(Stdio::piped())
            .spawn()
            .expect("csg runs");
        let mut line = String::new();
        let out = program.stdout.take().expect("its output");
        BufReader::new(out)
            .read_line(&mut line)
            .expect("an address");
        let (at, token) = line
            .trim()
            .strip_prefix("http://")
            .and_then(|rest| rest.split_once('/'))
            .unwrap_or_else(|| panic!("{line} is no address"));
        Self {
            at: at.parse().expect("an address and a port"),
            token: token.trim_end_matches('/').to_owned(),
            program,
        }
    }

    /// The status and the text that answer a request, with a `Host` of its own.
    fn ask(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &[u8],
    ) -> (u16, String) {
        let mut stream = TcpStream::connect(self.at).expect("a connection");
        let mut text = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n");
        let host = self.at.to_string();
        let names_host = headers.iter().any(|(name, _)| *name == "Host");
        let host = (!names_host).then_some(("Host", &*host));
        for (name, value) in headers.iter().copied().chain(host) {
            text += &format!("{name}: {value}\r\n");
        }
        if method == "POST" {
            let length = body.len();
            text += &format!("Content-Type: application/json\r\nContent-Length: {length}\r\n");
        }
        stream.write_all((text + "\r\n").as_bytes()).expect("sent");
        // (What is too long may be refused before all of it is sent.)
        let _ = stream.write_all(body);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let status = answer
            .split(' ')
            .nth(1)
            .and_then(|status| status.parse().ok());
        (
            status.unwrap_or_else(|| panic!("{path}: no answer, but {answer}")),
            answer,
        )
    }
}

fn only_the_page_is_answered() {
    let served = Served::new();
    let (at, token) = (served.at, &served.token);
    let page = format!("/{token}/");
    let get = |path: &str, headers: &[(&str, &str)]| served.ask("GET", path, headers, b"");
    let (status, text) = get(&page, &[]);
    assert_eq!(status, 200);
    let lower = text.to_lowercase();
    for header in [
        "content-security-policy: default-src 'self'",
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
    ] {
        assert!(lower.contains(header), "{header} is not in {text}");
    }
    // Without the token, or with another one.
    let wrong = "0123456789abcdef0123456789abcdef";
    for path in [
        "/",
        "/scene",
        "/view.js",
        &format!("/{wrong}/"),
        &format!("/{wrong}/scene"),
    ] {
        assert_eq!(get(path, &[]).0, 404, "{path}");
    }
    // From another place: a page of somebody else's, or a name of theirs that points here.
    let ours = format!("http://{at}");
    assert_eq!(get(&page, &[("Origin", &ours)]).0, 200);
    let local = format!("localhost:{}", at.port());
    assert_eq!(get(&page, &[("Host", &local)]).0, 200);
    let foreign = format!("evil.example:{}", at.port());
    for header in [
        ("Host", &*foreign),
        ("Host", "127.0.0.1"),
        ("Origin", "http://evil.example"),
        ("Origin", "null"),
        ("Sec-Fetch-Site", "cross-site"),
    ] {
        let (status, text) = get(&format!("/{token}/scene"), &[header]);
        assert_eq!(status, 403, "{header:?}: {text}");
    }
    while get(&format!("/{token}/scene"), &[]).0 == 204 {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    // Out of the page's own addresses.
    for path in [
        "../Cargo.toml",
        "../../../../etc/passwd",
        "..%2f..%2fetc%2fpasswd",
        "download/..%2f..%2fetc%2fpasswd",
        "download/../../etc/passwd",
        "download/exe",
        "view.js/../../Cargo.toml",
        "//etc/passwd",
    ] {
        let (status, text) = get(&format!("/{token}/{path}"), &[]);
        assert!(
            [404, 422].contains(&status) && !text.contains("root:"),
            "{path}: {text}"
        );
    }
    // What is asked is small, and makes sense.
    let post =
        |path: &str, body: &[u8]| served.ask("POST", &format!("/{token}/{path}"), &[], body).0;
    let long = vec![b' '; 1 << 20];
    for path in ["parameters", "describe", "between"] {
        assert_eq!(post(path, &long), 413, "{path}");
        assert_eq!(post(path, b"{"), 400, "{path}");
        assert_eq!(post(path, b"[7]"), 422, "{path}");
    }
    assert_eq!(
        post(
            "describe",
            br#"{"revision": 99, "pick": {"kind": "face", "id": 0}}"#
        ),
        409
    );
    assert_eq!(post("scene", b"{}"), 405);
    let long = "a".repeat(1 << 20);
    let (status, _) = get(&format!("/{token}/{long}"), &[]);
    assert!((400..500).contains(&status), "{status}");
    // Other machines find nobody there.
    let outside = UdpSocket::bind("0.0.0.0:0").and_then(|socket| {
        socket.connect("192.0.2.1:9")?;
        socket.local_addr()
    });
    assert_eq!(at.ip(), IpAddr::from([127, 0, 0, 1]));
    if let Ok(outside) = outside
        && !outside.ip().is_loopback()
    {
        let outside = SocketAddr::new(outside.ip(), at.port());
        assert!(TcpStream::connect(outside).is_err(), "{outside} answers");
    }
}

fn the_script_is_what_its_sources_make(web: &Path) {
    let made = web.join("dist");
    run(Command::new("node")
        .arg("build.js")
        .arg(&made)
        .current_dir(web));
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../view/web/dist");
    for name in ["view.js", "LICENSES.txt"] {
        let [made, kept] =
            [&made, &kept].map(|folder| fs::read(folder.join(name)).expect("a file"));
        assert!(
            made == kept,
            "{name} is not what the sources make: run `npm run build` in crates/view/web"
        );
    }
}

fn in_a_browser(web: &Path, chromium: &str) {
    let found = std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())
        .map(|folder| folder.join(chromium))
        .find(|program| program.is_file());
    let chromium =
        found.unwrap_or_else(|| panic!("STEREOTOMY_CHROMIUM is {chromium}, which is not there"));
    run(Command::new("node")
        .args(["--test", "--test-reporter=spec", "tests/view.test.js"])
        .env("CSG", env!("CARGO_BIN_EXE_csg"))
        .env("MODEL", std::env::current_exe().expect("this program"))
        .env("CHROMIUM", chromium)
        .current_dir(web));
}
