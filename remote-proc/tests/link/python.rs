//! The same forgeries by a session of another language, `eclipse-zenoh` of PyPI. `TROCAR_PYTHON` names an interpreter that has it.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;

use remote_proc::link::endpoint::Transport;
use remote_proc::link::keys::Side;
use remote_proc::protocol::{ASKED, keys};
use serde_json::{Value, json};
use zenoh::Wait;

use crate::support::authority::{Authority, Says, write};
use crate::support::forger::{ELSEWHERE, PATIENCE};
use crate::support::room::Room;

struct Forger {
    child: Child,
    says: Receiver<String>,
}

impl Forger {
    #[allow(clippy::disallowed_methods, reason = "a peer of a test is no process of a run")]
    fn start(python: &str, arguments: &[String]) -> Self {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/forge.py");
        let mut command = Command::new(python);
        command
            .arg(script)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let (tell, says) = channel();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| tell.send(line)));
        Self { child, says }
    }

    /// Its next line; one that says nothing fails the test by name, and does not hold it up.
    fn says(&mut self) -> Value {
        let line = self
            .says
            .recv_timeout(PATIENCE)
            .expect("the forger in Python says nothing more");
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: `{line}`"))
    }

    /// How often its queryables were asked, when it is told to go.
    fn ends(mut self) -> Value {
        drop(self.child.stdin.take());
        let last = self.says();
        assert!(self.child.wait().unwrap().success());
        last
    }
}

/// However a test ends, it leaves no forger behind.
impl Drop for Forger {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn python() -> Option<String> {
    let python = std::env::var("TROCAR_PYTHON").ok();
    if python.is_none() {
        println!("SKIPPED: TROCAR_PYTHON names no interpreter with eclipse-zenoh");
    }
    python
}

fn arguments(mode: &str, room: &Room, files: &[PathBuf]) -> Vec<String> {
    let files = files.iter().map(|file| file.display().to_string());
    let keys = keys().chain(ELSEWHERE).collect::<Vec<_>>().join(",");
    [mode.to_owned(), room.endpoint.clone(), keys]
        .into_iter()
        .chain(files)
        .collect()
}

fn receivers(room: &Room) -> Vec<PathBuf> {
    let folder = room.keys.path();
    vec![
        folder.join("authority.pem"),
        Side::Receiver.certificate_file(folder),
        Side::Receiver.key_file(folder),
    ]
}

#[test]
fn a_forger_in_python_with_a_receivers_certificate_or_on_loopback_reaches_nobody() {
    let Some(python) = python() else { return };
    for transport in [Transport::Tls, Transport::Tcp] {
        for mode in ["client", "peer"] {
            let room = Room::open(transport);
            let screen = room.receiver();
            let files = if transport == Transport::Tls {
                receivers(&room)
            } else {
                vec![]
            };
            let mut forger = Forger::start(&python, &arguments(mode, &room, &files));
            // Its query was answered, so that it is heard where it may be.
            assert_eq!(forger.says(), json!({ "open": true, "answers": ["the sender's"] }));
            room.session.put("trocar/1/event", "last").wait().unwrap();
            assert_eq!(
                screen.heard_until("trocar/1/event last"),
                ["trocar/1/event last"],
                "{transport:?} {mode}"
            );
            for key in keys() {
                let wanted = usize::from(ASKED.contains(&key));
                assert_eq!(
                    screen.ask(key),
                    vec!["the sender's"; wanted],
                    "{transport:?} {mode} {key}"
                );
            }
            assert_eq!(forger.ends(), json!({ "asked": 0 }), "{transport:?} {mode}");
            assert_eq!(room.heard(), [""; 0], "{transport:?} {mode}");
        }
    }
}

/// What the test above would see if the rules were not there.
#[test]
fn without_access_control_the_forger_in_python_is_heard() {
    let Some(python) = python() else { return };
    let room = Room::without_control(Transport::Tls);
    let screen = room.receiver();
    let mut forger = Forger::start(&python, &arguments("client", &room, &receivers(&room)));
    assert_eq!(forger.says()["open"], true);
    room.session.put("trocar/1/event", "last").wait().unwrap();
    for heard in [screen.heard_until("trocar/1/event last"), room.heard()] {
        for key in keys() {
            assert!(heard.contains(&format!("{key} forged")), "{key}: {heard:?}");
        }
    }
    assert!(screen.ask("trocar/1/facts").contains(&"forged".to_owned()));
    assert_ne!(forger.ends(), json!({ "asked": 0 }));
}

#[test]
fn a_forger_in_python_without_a_certificate_or_with_one_of_another_authority_is_not_let_in() {
    let Some(python) = python() else { return };
    let room = Room::open(Transport::Tls);
    let (certificate, key) = Authority::new("another").signs(&Says::of(Side::Receiver));
    let [of_certificate, of_key] = ["other.pem", "other.key"].map(|name| room.keys.path().join(name));
    write(&of_certificate, &certificate);
    write(&of_key, &key);
    let authority = room.keys.path().join("authority.pem");
    for files in [vec![], vec![authority.clone()], vec![authority, of_certificate, of_key]] {
        let mut forger = Forger::start(&python, &arguments("client", &room, &files));
        assert_eq!(forger.says(), json!({ "open": false }));
        assert!(forger.child.wait().unwrap().success());
    }
    assert_eq!(room.heard(), [""; 0]);
}
