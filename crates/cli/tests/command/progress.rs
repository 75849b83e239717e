//! The line that tells how far a command is, on a terminal that Python plays.

use std::process::Command;

use super::{Folder, succeeded};

/// Runs a command whose errors go to a terminal, as slowly as is needed to see the line: its
/// scene comes once it is said to be read, and its file, a pipe, is taken once it is said to be
/// written. Prints what it said before its scene came, and once its file was taken.
const PLAYED: &str = r#"
import fcntl, os, pty, select, signal, struct, subprocess, sys, termios, threading, time
PATIENCE = 60
# (A command that fails never opens the pipe.)
signal.alarm(4 * PATIENCE)
quiet = sys.argv[2:]
os.mkfifo("out.stl")
ours, theirs = pty.openpty()
fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
command = [sys.argv[1], "mesh", "-", "-o", "out.stl", *quiet]
child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=theirs)
os.close(theirs)

def heard(word, seconds):
    "What is said until a word."
    said, end = "", time.monotonic() + seconds
    while word not in said and time.monotonic() < end:
        if select.select([ours], [], [], 0.1)[0]:
            try:
                said += os.read(ours, 65536).decode(errors="replace")
            except OSError:
                break
    return said

# (Who is quiet says nothing however long one waits.)
reading = heard("reading", 1.5 if quiet else PATIENCE)
child.stdin.write(open("in.csg", "rb").read())
child.stdin.close()
pipe = os.open("out.stl", os.O_RDONLY)
taken = 0
while taken < 600_000:
    taken += len(os.read(pipe, 65536))
writing = heard("kB", 1.5 if quiet else PATIENCE)
def take():
    while os.read(pipe, 65536):
        pass
taker = threading.Thread(target=take)
taker.start()
writing += heard("wrote out.stl", 1.5 if quiet else PATIENCE)
taker.join()
assert child.wait() == 0, child.returncode
print(reading)
print("=====")
print(writing)
"#;

/// What the command says on a terminal while it reads, and from then on.
#[cfg(unix)]
fn said(arguments: &[&str]) -> [String; 2] {
    let folder = Folder::new();
    let played = Command::new("python3")
        .args(["-c", PLAYED, env!("CARGO_BIN_EXE_csg")])
        .args(arguments)
        .current_dir(folder.0.path())
        .output();
    let printed = succeeded(&played.expect("Python 3")).stdout.clone();
    let printed = String::from_utf8(printed).expect("text");
    let (reading, writing) = printed.split_once("=====").expect("both");
    [reading, writing].map(|said| said.trim().to_owned())
}

/// No share is made up where none is known; what is written is counted.
#[test]
#[cfg(unix)]
fn a_share_is_shown_where_it_is_known() {
    let [reading, writing] = said(&["--tolerance", "1e-4"]);
    assert!(reading.contains("reading"), "{reading}");
    assert!(!reading.contains('%'), "{reading}");
    let line = |said: &str, word: &str| {
        let mut lines = said.split(['\r', '\n']);
        let line = lines.find(|line| line.contains(word)).map(str::to_owned);
        line.unwrap_or_else(|| panic!("no {word} in {said}"))
    };
    let written = line(&writing, "kB");
    assert!(
        written.contains("writing") && !written.contains('%'),
        "{written}"
    );
    assert!(writing.contains("wrote out.stl"), "{writing}");
}

/// Who is quiet shows nothing of it.
#[test]
#[cfg(unix)]
fn quiet_commands_show_nothing() {
    assert_eq!(said(&["--tolerance", "1e-4", "--quiet"]), ["", ""]);
}
