//! A server and clients that speak the protocol by hand.

use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, TcpStream};
use std::path::Path;
use std::sync::mpsc;

use bus::message::{Lost, Tracked};
use prost::Message as _;
use serde_json::{Value, json};

use super::*;
use crate::testing;
use crate::wire::proto::FrameTransform;

/// Everything that a test waits for comes long before.
const PATIENCE: Duration = Duration::from_secs(60);

fn outlet() -> Outlet {
    let scene = Scene::parse("", Path::new("s.toml")).unwrap();
    Outlet::start(&scene, "", SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 0)).unwrap()
}

struct Client(TcpStream);

impl Client {
    /// Connects, and has subscribed to the topics named.
    fn of(outlet: &Outlet, topics: &[&str]) -> Self {
        let mut socket = TcpStream::connect((Ipv4Addr::LOCALHOST, outlet.port())).unwrap();
        socket.set_read_timeout(Some(PATIENCE)).unwrap();
        let request = "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                       Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n";
        socket.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            socket.read_exact(&mut byte).unwrap();
            answer.push(byte[0]);
        }
        assert!(
            answer.starts_with(b"HTTP/1.1 101"),
            "{}",
            String::from_utf8_lossy(&answer)
        );
        let mut client = Self(socket);
        let advertised = client.told("advertise");
        let channels = advertised["channels"].as_array().unwrap();
        let is_asked = |channel: &&Value| topics.contains(&channel["topic"].as_str().unwrap());
        let ids: Vec<_> = channels
            .iter()
            .filter(is_asked)
            .map(|channel| channel["id"].clone())
            .collect();
        assert_eq!(ids.len(), topics.len(), "{advertised}");
        let subscriptions: Vec<_> = ids.iter().map(|id| json!({"id": id, "channelId": id})).collect();
        client.say(&json!({"op": "subscribe", "subscriptions": subscriptions}));
        client
    }

    fn say(&mut self, message: &Value) {
        self.frame(1, message.to_string().as_bytes());
    }

    /// A whole message of a client, with a mask of zeros.
    fn frame(&mut self, opcode: u8, bytes: &[u8]) {
        let mut frame = vec![0x80 | opcode, 0x80 | 127];
        frame.extend((bytes.len() as u64).to_be_bytes());
        frame.extend([0; 4]);
        frame.extend(bytes);
        self.0.write_all(&frame).unwrap();
    }

    /// The next message: its opcode and its bytes.
    fn next(&mut self) -> (u8, Vec<u8>) {
        let mut take = |n: usize| {
            let mut bytes = vec![0; n];
            self.0.read_exact(&mut bytes).unwrap();
            bytes
        };
        let head = take(2);
        let length = match head[1] & 127 {
            126 => take(2).iter().fold(0, |n, byte| n << 8 | usize::from(*byte)),
            127 => take(8).iter().fold(0, |n, byte| n << 8 | usize::from(*byte)),
            short => usize::from(short),
        };
        (head[0] & 15, take(length))
    }

    /// The next message in words with this `op`.
    fn told(&mut self, op: &str) -> Value {
        loop {
            let (opcode, bytes) = self.next();
            if opcode == 1 {
                let message: Value = serde_json::from_slice(&bytes).unwrap();
                if message["op"] == op {
                    return message;
                }
            }
        }
    }

    /// The payload of the next message of a channel.
    fn data(&mut self) -> Vec<u8> {
        loop {
            let (opcode, bytes) = self.next();
            if opcode == 2 && bytes[0] == 1 {
                return bytes[13..].to_vec();
            }
        }
    }

    fn transform(&mut self) -> FrameTransform {
        FrameTransform::decode(&self.data()[..]).unwrap()
    }
}

/// Until the subscription has come to the server.
fn wait_until(is_so: impl Fn() -> bool) {
    let rounds = PATIENCE.as_millis() / 5;
    assert!((0..rounds).any(|_| is_so() || {
        std::thread::sleep(Duration::from_millis(5));
        false
    }));
}

fn is_watched(outlet: &Outlet, channel: u16) -> bool {
    outlet.channels[&channel].has_sinks()
}

/// Foxglove draws the axes of each frame for ever where its last transform put them, also those of a tool that was lost long ago.
#[test]
fn the_transform_of_a_tool_without_a_pose_is_taken_away_and_none_is_told() {
    let mut outlet = outlet();
    let mut client = Client::of(&outlet, &["/tf"]);
    wait_until(|| is_watched(&outlet, TF_CHANNEL));
    let put = |outlet: &mut Outlet, seq| outlet.put(0, Entry::Pose(Source::Tool, &testing::pose(seq)));
    // The images claim none yet.
    put(&mut outlet, 1);
    outlet.tool(0, true);
    put(&mut outlet, 2);
    outlet.tool(0, false);
    put(&mut outlet, 3);
    outlet.tool(0, true);
    put(&mut outlet, 4);
    outlet.transform(&testing::pose(5));
    let told: Vec<_> = (0..4).map(|_| client.transform()).collect();
    let parents: Vec<_> = told.iter().map(|told| told.parent_frame_id.as_str()).collect();
    assert_eq!(parents, ["ct", "NO POSE", "ct", "ct"]);
    assert!(told.iter().all(|told| told.child_frame_id == "tool"), "{told:?}");
    let of = |seq| proto::frame_transform_in_metres(&testing::pose(seq), "tool").unwrap();
    assert_eq!([&told[0], &told[2], &told[3]], [&of(2), &of(4), &of(5)]);
    // Metres, and the quaternion by the names of its parts.
    let (pose, rotation) = (testing::pose(2), told[0].rotation.clone().unwrap());
    assert!((told[0].translation.as_ref().unwrap().x - pose.t_mm[0] / 1e3).abs() < 1e-12);
    assert_eq!([rotation.w, rotation.x, rotation.y, rotation.z], pose.q);
}

#[test]
fn a_lost_pose_has_no_transform_and_its_numbers_say_why() {
    let mut outlet = outlet();
    let mut client = Client::of(&outlet, &["/tool_pose", "/tf"]);
    wait_until(|| is_watched(&outlet, TF_CHANNEL) && is_watched(&outlet, Source::Tool.channel()));
    outlet.tool(0, true);
    for reason in Lost::ALL {
        let mut lost = testing::pose(1);
        lost.set(Tracked::Lost(reason));
        outlet.put(0, Entry::Pose(Source::Tool, &lost));
        let told = proto::ToolPose::decode(&client.data()[..]).unwrap();
        assert_eq!(told, proto::ToolPose::from(&lost));
    }
}

/// What is asked for is refused in words, what is no message at all too, and the client next to it misses nothing.
#[test]
fn nothing_that_a_client_sends_is_taken_and_no_other_client_notices() {
    let mut outlet = outlet();
    let mut bad = Client::of(&outlet, &["/tf"]);
    let mut good = Client::of(&outlet, &["/tf"]);
    wait_until(|| outlet.server.client_count() == 2 && is_watched(&outlet, TF_CHANNEL));
    let channel = json!({"id": 1, "topic": "/tool_pose", "encoding": "json", "schemaName": "x"});
    let asked = [
        (json!({"op": "advertise", "channels": [channel]}), "clientPublish"),
        (
            json!({"op": "getParameters", "parameterNames": [], "id": "1"}),
            "parameters",
        ),
        (
            json!({"op": "setParameters", "parameters": [{"name": "a", "value": 1}]}),
            "parameters",
        ),
        (
            json!({"op": "subscribeParameterUpdates", "parameterNames": ["a"]}),
            "parameters",
        ),
        (json!({"op": "subscribeConnectionGraph"}), "connection graph"),
        // A file of this machine.
        (
            json!({"op": "fetchAsset", "uri": "file:///etc/passwd", "requestId": 7}),
            "assets",
        ),
        (
            json!({"op": "subscribe", "subscriptions": [{"id": 9, "channelId": 999_999}]}),
            "Unknown channel",
        ),
        (json!({"op": "no such thing"}), "Invalid message"),
        (json!([[[[[]]]]]), "Invalid message"),
    ];
    for (message, expected) in asked {
        bad.say(&message);
        let status = bad.told("status");
        let words = status["message"].as_str().unwrap();
        assert!(words.contains(expected), "{message}: {words}");
    }
    // A message on a channel that it never may have.
    bad.frame(2, &[1, 1, 0, 0, 0, 1, 2, 3]);
    assert!(
        bad.told("status")["message"]
            .as_str()
            .unwrap()
            .contains("Unknown channel")
    );
    // A call of a service: its number, that of the call, an encoding of no length.
    bad.frame(2, &[2, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
    let refused = bad.told("serviceCallFailure");
    assert!(
        refused["message"].as_str().unwrap().contains("does not support"),
        "{refused}"
    );
    // Frames that are none, of a length that nobody has.
    bad.0.write_all(&[0xff; 14]).unwrap();
    outlet.tool(0, true);
    outlet.put(0, Entry::Pose(Source::Tool, &testing::pose(5)));
    assert_eq!(good.transform().parent_frame_id, "ct");
    wait_until(|| outlet.server.client_count() == 1);
}

/// A client that reads nothing held up the end of the process for ever, as the server waited until it had read that it is closed.
#[test]
fn a_client_that_reads_nothing_holds_up_neither_what_is_told_nor_the_end() {
    let mut outlet = outlet();
    let clients: Vec<_> = (0..3).map(|_| Client::of(&outlet, &["/log"])).collect();
    wait_until(|| outlet.server.client_count() == 3 && is_watched(&outlet, schema::LOG_CHANNEL));
    // More than the system takes on for a socket that is not read, and than the server keeps.
    let log = proto::Log::new(0, bus::message::Level::Info, "test", "x".repeat(1 << 20));
    for _ in 0..2 * BACKLOG {
        outlet.put(0, Entry::Log(0, &log));
    }
    let (done, wait) = mpsc::channel();
    std::thread::spawn(move || {
        outlet.stop();
        let _ = done.send(());
    });
    assert_eq!(wait.recv_timeout(PATIENCE), Ok(()));
    drop(clients);
}

/// The system takes megabytes on for who reads slowly, and he saw a tool where it was twenty seconds before.
#[test]
fn a_client_that_does_not_keep_up_is_closed_alone() {
    let mut outlet = outlet();
    let _slow = Client::of(&outlet, &["/log"]);
    let mut good = Client::of(&outlet, &["/tf"]);
    wait_until(|| {
        outlet.server.client_count() == 2 && is_watched(&outlet, schema::LOG_CHANNEL) && is_watched(&outlet, TF_CHANNEL)
    });
    let log = proto::Log::new(0, bus::message::Level::Info, "test", "x".repeat(1 << 20));
    (0..2 * BACKLOG).for_each(|_| outlet.put(0, Entry::Log(0, &log)));
    let late = std::cell::RefCell::new((crate::serve::late::Late::new(outlet.port()), 0));
    wait_until(|| {
        let (late, steady_ns) = &mut *late.borrow_mut();
        *steady_ns += 1_000_000_000;
        late.step(*steady_ns);
        outlet.server.client_count() == 1
    });
    outlet.tool(0, true);
    outlet.put(0, Entry::Pose(Source::Tool, &testing::pose(5)));
    assert_eq!(good.transform().parent_frame_id, "ct");
}

#[test]
fn a_port_that_is_taken_is_named_with_the_reason() {
    let first = outlet();
    let scene = Scene::parse("", Path::new("s.toml")).unwrap();
    let address = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), first.port());
    let Err(error) = Outlet::start(&scene, "", address) else {
        panic!()
    };
    let words = error.to_string();
    assert!(
        words.contains(&address.to_string()) && words.contains("in use"),
        "{words}"
    );
}

#[test]
fn who_comes_late_is_told_what_comes_only_when_it_changes() {
    let mut outlet = outlet();
    let workflow = bus::message::Workflow {
        flags: Workflow::IMAGES,
        ..Workflow::default()
    };
    outlet.put(0, Entry::Workflow(&proto::Workflow::from(&workflow)));
    assert!(outlet.workflow().unwrap().has(Workflow::IMAGES));
    let mut client = Client::of(&outlet, &["/workflow"]);
    wait_until(|| is_watched(&outlet, schema::WORKFLOW_CHANNEL));
    outlet.again();
    let told = proto::Workflow::decode(&client.data()[..]).unwrap();
    assert_eq!(told, proto::Workflow::from(&workflow));
}

#[test]
fn a_replay_is_called_so_beside_the_address() {
    assert_eq!(name(""), "Trocar, RESEARCH DISPLAY");
    assert_eq!(name("REPLAY, NOT LIVE"), "Trocar, RESEARCH DISPLAY: REPLAY, NOT LIVE");
}
