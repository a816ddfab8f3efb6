//! A device of NDI that answers polls with what no device should, to a real run: what is told, and no wrong pose.

#![allow(clippy::disallowed_methods, reason = "how long a test waits is its own time")]

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use bus::message::Lost;
use ndi::status::ToolStatus;
use ndi::{Bx2, Bx2Frame, Bx2Tool, FrameKind, Handle, Rom, Transform, binary_reply, bx2_body, crc::crc16, text_reply};

use crate::support::frames::{Watch, tool};
use crate::support::{SMALL, World};

/// Where a good pose lies, and where one that must never be shown, mm.
const GOOD: f64 = 10.0;
const BAD: f64 = 666.0;
/// The handle that the device gives the tool.
const FOLLOWED: u16 = 1;
/// For one thing of a case.
const PATIENCE: Duration = Duration::from_secs(30);
/// How much a number of a frame may leave out before it is another count.
const JUMP: u32 = 1_000_000;

/// The body of a poll's reply: the tool that is followed, at x.
fn seen(number: u32, x: f64, status: u16) -> Vec<u8> {
    body(number, &[(FOLLOWED, x, status)])
}

/// The body of a poll's reply: tools by their handles, each at x.
fn body(number: u32, tools: &[(u16, f64, u16)]) -> Vec<u8> {
    let frame = Bx2Frame {
        kind: FrameKind(2),
        index: 0,
        status: ToolStatus(0),
        number,
        device_ns: i64::from(number) * 16_000_000 + 1_000_000_000,
        tools: tools
            .iter()
            .map(|(handle, x, status)| placed(*handle, *x, *status))
            .collect(),
        markers: Vec::new(),
        errors: Vec::new(),
    };
    bx2_body(&Bx2 {
        frames: vec![frame],
        alerts: Vec::new(),
        skipped: 0,
    })
}

fn placed(handle: u16, x: f64, status: u16) -> Bx2Tool {
    let transform = Transform {
        q: [1.0, 0.0, 0.0, 0.0],
        t_mm: [x, 2.0, -1500.0],
        error_mm: 0.1,
    };
    Bx2Tool {
        handle: Handle(handle),
        status: ToolStatus(status),
        transform: (status & 0x0100 == 0).then_some(transform),
    }
}

/// What the device says next, once, given the number of the frame.
type Evil = fn(u32) -> Vec<u8>;

/// The reply with other bytes in its body.
fn changed(number: u32, at: usize, with: &[u8]) -> Vec<u8> {
    let mut body = seen(number, BAD, 0);
    body[at..at + with.len()].copy_from_slice(with);
    binary_reply(&body)
}

/// The reply with other bytes anywhere.
fn damaged(number: u32, at: usize) -> Vec<u8> {
    let mut reply = binary_reply(&seen(number, BAD, 0));
    reply[at] ^= 0x55;
    reply
}

fn too_long(number: u32) -> Vec<u8> {
    let reply = binary_reply(&seen(number, BAD, 0));
    let head = [0xC4, 0xA5, 0xFF, 0xFF];
    [&head[..], &crc16(&head).to_le_bytes(), &reply[6..]].concat()
}

fn broken_off(number: u32) -> Vec<u8> {
    let mut reply = binary_reply(&seen(number, BAD, 0));
    let text = text_reply("ERROR0C");
    reply[20..20 + text.len()].copy_from_slice(&text);
    reply
}

/// What comes of it.
enum Then {
    /// These words, and no pose of it.
    Words(&'static str),
    /// No pose, for this reason.
    Lost(Lost),
    /// Nothing: the pose is not shown.
    Nothing,
    /// Nothing, nor is the tool lost: the frame is not about it.
    Unchanged,
}

fn cases() -> Vec<(&'static str, Evil, Then)> {
    use Then::{Nothing, Words};
    vec![
        ("header CRC", |n| damaged(n, 4), Words("the header has CRC")),
        ("body CRC", |n| damaged(n, 70), Words("the body has CRC")),
        ("a length of 65535", too_long, Words("was not answered within")),
        (
            "2^31 frames",
            |n| changed(n, 12, &(1_u32 << 31).to_le_bytes()),
            Words("BX2"),
        ),
        (
            "component of 0",
            |n| changed(n, 6, &[0; 4]),
            Words("a component of 0 bytes"),
        ),
        (
            "a frame in a frame",
            |n| changed(n, 36, &[1, 0]),
            Words("deep; allowed are"),
        ),
        (
            "2e9 ns",
            |n| changed(n, 28, &2_000_000_000_u32.to_le_bytes()),
            Words("2000000000 nanoseconds"),
        ),
        (
            "NaN",
            |n| changed(n, 68, &f32::NAN.to_le_bytes()),
            Then::Lost(Lost::Refused),
        ),
        ("zeros", |n| changed(n, 52, &[0; 16]), Then::Lost(Lost::Refused)),
        (
            "another command's answer",
            |_| text_reply("OKAY"),
            Words("what came is no answer to BX2"),
        ),
        (
            "an error in the middle",
            broken_off,
            Words("ERROR0C stands in the middle of a binary reply"),
        ),
        (
            "a reset",
            |_| text_reply("RESET"),
            Words("the device was reset: it is set up again"),
        ),
        (
            "words that steer",
            |_| b"\x1b[2J0000\r".to_vec(),
            Words("byte 0x1b in a text"),
        ),
        (
            "missing",
            |n| binary_reply(&seen(n, BAD, 0x0100)),
            Then::Lost(Lost::NotSeen),
        ),
        (
            "bad fit",
            |n| binary_reply(&seen(n, BAD, 17)),
            Then::Lost(Lost::Residual),
        ),
        (
            "out of sync",
            |n| binary_reply(&seen(n, BAD, 21)),
            Then::Lost(Lost::Refused),
        ),
        (
            "a code that nobody knows",
            |n| binary_reply(&seen(n, BAD, 77)),
            Then::Lost(Lost::Refused),
        ),
        (
            "a frame of another tool, as passive and active ones alternate",
            |n| binary_reply(&body(n, &[(2, BAD, 0)])),
            Then::Unchanged,
        ),
        ("a frame of no tool", |n| binary_reply(&body(n, &[])), Then::Unchanged),
        (
            "another tool beside it",
            |n| binary_reply(&body(n, &[(2, BAD, 0), (FOLLOWED, GOOD, 0)])),
            Then::Unchanged,
        ),
        (
            "another tool beside it, which is missing",
            |n| binary_reply(&body(n, &[(2, BAD, 0), (FOLLOWED, BAD, 0x0100)])),
            Then::Lost(Lost::NotSeen),
        ),
        (
            "a reply of before",
            |n| binary_reply(&seen(n - 120, BAD, 0)),
            Words("gave a reply of before"),
        ),
        ("a number twice", |n| binary_reply(&seen(n - 1, BAD, 0)), Nothing),
        (
            "a number far off",
            |n| binary_reply(&seen(n + JUMP, BAD, 0x0100)),
            Words("after frame"),
        ),
    ]
}

/// The device: one tool that moves, and what it is told to say next.
fn serve(mut stream: TcpStream, number: &mut u32, next: &Mutex<Option<Evil>>) -> Option<()> {
    stream.set_nodelay(true).unwrap();
    let mut command = Vec::new();
    loop {
        let mut byte = [0];
        stream.read_exact(&mut byte).ok()?;
        if byte != *b"\r" {
            command.extend(byte);
            continue;
        }
        let words = String::from_utf8_lossy(&command).into_owned();
        command.clear();
        let reply = match words.split([':', ' ']).next().unwrap() {
            "VER" => text_reply("a device of this test"),
            "PHSR" => text_reply("00"),
            "PHRQ" => text_reply("01"),
            "BX2" => {
                *number += 1;
                thread::sleep(Duration::from_millis(5));
                match next.lock().unwrap().take() {
                    Some(evil) => evil(*number),
                    None => binary_reply(&seen(*number, GOOD + f64::from(*number % 800) / 8.0, 0)),
                }
            }
            _ => text_reply("OKAY"),
        };
        stream.write_all(&reply).ok()?;
    }
}

#[test]
fn what_no_device_should_send_is_named_and_shows_no_pose() {
    let world = World::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let next: Arc<Mutex<Option<Evil>>> = Arc::default();
    let said = Arc::clone(&next);
    thread::spawn(move || {
        let mut number = 1000;
        for stream in listener.incoming().flatten() {
            serve(stream, &mut number, &said);
        }
    });
    let places = [[0.0; 3], [50.0, 0.0, 0.0], [0.0, 60.0, 0.0], [0.0, 0.0, 70.0]];
    std::fs::write(
        world.path("tool.rom"),
        Rom::simulated("Trocar", "test", &places).unwrap().bytes(),
    )
    .unwrap();
    let scene = SMALL.replace("[tracker]\n", "[tracker]\nsource = \"markers\"\n")
        + &format!(
            "[tracker.markers]\nmarker = \"ball\"\n[localizer]\nkind = \"ndi\"\naddress = \"127.0.0.1:{port}\"\n\
             [[localizer.tools]]\nname = \"ball\"\nrom = {:?}\n",
            Path::new("tool.rom")
        );
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    let watch = Watch::open(&world);
    let mut failed = Vec::new();
    for (name, evil, then) in cases() {
        watch.wait("good poses", 3, |frame| tool(frame).is_ok());
        drop((watch.told(), watch.come()));
        *next.lock().unwrap() = Some(evil);
        let (mut told, mut lost) = (Vec::new(), Vec::new());
        let began = Instant::now();
        let found = loop {
            told.extend(watch.told());
            for frame in watch.come() {
                match tool(&frame) {
                    Ok(pose) => assert!(pose.translation_mm()[0] != BAD, "{name}: {frame:?}"),
                    Err(reason) => lost.push(reason),
                }
            }
            let is_sent = next.lock().unwrap().is_none();
            let is_there = match then {
                Then::Words(words) => told.iter().any(|told: &String| told.contains(words)),
                Then::Lost(reason) => lost.contains(&reason),
                Then::Unchanged if !lost.is_empty() => break false,
                Then::Nothing | Then::Unchanged => is_sent && began.elapsed() > Duration::from_millis(100),
            };
            if is_there || began.elapsed() > PATIENCE {
                break is_there;
            }
            thread::sleep(Duration::from_millis(2));
        };
        if !found {
            failed.push(format!("{name}: told {told:?}, lost {lost:?}"));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
    let _ = pilot.stop();
}
