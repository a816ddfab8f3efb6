//! What is stated, and the moments in which it could be false: a server that stood still, a run that ends, a recording that stands still,
//! streams that were refused, an examination that is not the patient's.

use std::time::Duration;

use bus::message::{ClockLaw, ToolPose, Tracked, Workflow};
use bus::port::Publisher;
use bus::topic::SESSION_CLOCK;
use geometry::{Affine, VolumeGrid};
use igtl::{Body, Command, DeviceName, Kind, Message, Name, Query, Status, Text, ToolStatus, Version};
use rustix::process::Signal;

use crate::pictures::{header, pixels};
use crate::poses::{get, transform};
use crate::rig::{Raw, Rig, SCENE, place};

/// The words of a message that says how the tool is.
fn state(message: &Message<'_>) -> Option<String> {
    match &message.body {
        Body::Status(status) => Some(String::from_utf8_lossy(&status.words).into_owned()),
        Body::String(text) if message.device == "State" => Some(text.to_string()),
        Body::CommandAnswer(answer) => Some(answer.content.to_string()),
        _ => None,
    }
}

fn code(message: &Message<'_>) -> Option<u16> {
    match &message.body {
        Body::Status(status) => Some(status.code),
        _ => None,
    }
}

/// The process stood still, as on a machine that slept: what waits with it was true before. Whoever asks then is not told that.
#[test]
fn a_server_that_stood_still_says_of_no_old_pose_that_it_is_live() {
    let rig = Rig::new();
    let mut seq = 0;
    for round in 0..10 {
        let mut before = rig.client();
        rig.pose(seq);
        before.wait_for("LIVE", |message| {
            (message.device == "State" && state(message)?.starts_with("LIVE")).then_some(())
        });
        rig.pose(seq + 1);
        seq += 2;
        rig.signal(Signal::STOP);
        let mut late = rig.client();
        for kind in [Kind::Status, Kind::String, Kind::Transform, Kind::Tdata] {
            late.send(&get(kind, Version::Two));
        }
        let command = Command {
            number: 1,
            name: Name::new("State").unwrap(),
            content: Text::new(""),
        };
        late.send(&Message::new(DeviceName::EMPTY, Body::Command(command)).in_version(Version::Two));
        late.send(&get(Kind::Capability, Version::Two));
        // Longer than a pose is young.
        std::thread::sleep(Duration::from_millis(150));
        rig.signal(Signal::CONT);
        late.wait_for("the last answer", |message| {
            assert_ne!(code(message), Some(Status::OK), "round {round}: {message:?}");
            let is_live = state(message).is_some_and(|words| words.starts_with("LIVE"));
            assert!(!is_live, "round {round}: {message:?}");
            let is_pose = transform(message).is_some_and(|(status, ..)| status.is_ok());
            assert!(!is_pose, "round {round}: {message:?}");
            matches!(message.body, Body::Capability(_)).then_some(())
        });
    }
}

/// All that was shown before lay elsewhere in the patient: every client is told, asked or not.
#[test]
fn a_registration_that_changes_is_an_alarm_to_every_client() {
    let rig = Rig::new();
    let mut clients = [rig.client(), rig.client()];
    rig.pose_by(0, 1);
    for client in &mut clients {
        client.wait_for("LIVE", |message| {
            assert_ne!(message.device, "Alarm", "{message:?}");
            (message.device == "State" && state(message)?.starts_with("LIVE")).then_some(())
        });
    }
    rig.pose_by(1, 2);
    for client in &mut clients {
        let words = client.wait_for("the alarm", |message| match &message.body {
            Body::String(text) if message.device == "Alarm" => Some(text.to_string()),
            _ => None,
        });
        assert_eq!(words, "THE REGISTRATION CHANGED: it is 0000000000000002 now");
    }
}

/// 3D Slicer and others keep the last transform of a connection that has ended.
#[test]
fn a_run_that_ends_takes_its_pose_back() {
    let rig = Rig::new();
    let (mut one, mut two) = (rig.client(), rig.client());
    two.send(&get(Kind::Status, Version::Two));
    let mut seq = 0;
    for (client, version) in [(&mut one, Version::One), (&mut two, Version::Two)] {
        loop {
            let message = client.next_while(|| {
                rig.pose(seq);
                seq += 1;
            });
            let message = message.unwrap();
            if message.version == version && transform(&message).is_some() {
                break;
            }
        }
    }
    rig.signal(Signal::TERM);
    let last = |client: &mut Raw| {
        let (mut pose, mut status, mut words) = (None, None, None);
        while let Some(message) = client.next() {
            pose = transform(&message).or(pose);
            status = code(&message).or(status);
            words = state(&message).or(words);
        }
        (pose, status.unwrap(), words.unwrap())
    };
    let (pose, code, words) = last(&mut two);
    let (status, _, why) = pose.unwrap();
    assert_eq!(
        (status, why.as_str()),
        (ToolStatus::Missing, "ENDED: the run has ended")
    );
    assert!(
        code != Status::OK && words.starts_with("ENDED: the run has ended"),
        "{words}"
    );
    let (_, code, words) = last(&mut one);
    assert!(
        code != Status::OK && words.starts_with("ENDED: the run has ended"),
        "{words}"
    );
}

/// Images said FROZEN there, and the gateway that the pose is valid.
#[test]
fn what_stands_still_in_a_replay_is_frozen_as_on_the_images() {
    let rig = Rig::of(SCENE, Rig::replayed);
    let laws: Publisher<ClockLaw> = Publisher::open(&rig.bus, &SESSION_CLOCK, "").unwrap();
    let mut two = rig.client();
    two.send(&get(Kind::Status, Version::Two));
    let mut told = |seq: u64, at: u64| {
        let now_ns = 1_000_000_000 + 50_000_000 * seq as i64;
        laws.send(ClockLaw {
            anchor_ns: now_ns,
            ..ClockLaw::default()
        })
        .unwrap();
        let mut sample = ToolPose {
            seq,
            t_capture_ns: now_ns,
            t_publish_ns: now_ns,
            ..ToolPose::EMPTY
        };
        sample.set(Tracked::Valid(place(at)));
        rig.tool.send(sample).unwrap();
        let number = sample.seq.to_string();
        two.wait_for("this sample", |message| {
            let (status, _, why) = transform(message)?;
            let is_this =
                message.number == seq as u32 || message.metadata.get("PoseNumber") == Some(&Text::new(&number));
            is_this.then_some((status.is_ok(), why))
        })
    };
    // 0.5 s is the default of `limits.frozen_ms`.
    for seq in 1..=11 {
        assert_eq!(told(seq, 7), (true, String::new()), "{seq}");
    }
    assert_eq!(told(12, 7), (false, "LOST: FROZEN MEASUREMENT".to_owned()));
    assert_eq!(told(13, 8), (true, String::new()));
}

const VIEWS: &str = "[gateway]\naddress = \"127.0.0.1:0\"\nimages_hz = 0.1\n[limits]\nstale_ms = 10000.0\n";

fn start() -> Query {
    Query::Start(Kind::Image, Default::default())
}

fn ask(client: &mut Raw, device: &str, query: Query) -> u8 {
    let device = DeviceName::new(device).unwrap();
    client.send(&Message::new(device, Body::Query(query)).in_version(Version::Two));
    client.wait_for("RTS_IMAGE", |message| match message.body {
        Body::Query(Query::Answer(Kind::Image, status)) => Some(status),
        _ => None,
    })
}

/// A stream of an unknown view was said to have begun, and one of two that had begun could not be ended.
#[test]
fn what_is_answered_of_a_stream_of_images_is_what_becomes_of_it() {
    let rig = Rig::of(&format!("{SCENE}images_hz = 60.0\n"), |_| ());
    let view = rig.view("axial-local", pixels().len());
    let mut client = rig.client();
    let stop = Query::Stop(Kind::Image);
    assert_eq!(ask(&mut client, "axial-local", stop), 1, "it had not begun");
    assert_eq!(ask(&mut client, "nobody", start()), 1);
    assert_eq!(ask(&mut client, "nobody", stop), 1);
    for _ in 0..20 {
        rig.frame(&view, header(&rig, true), &pixels());
        std::thread::sleep(Duration::from_millis(10));
    }
    client.send(&get(Kind::Capability, Version::Two));
    client.wait_for("the answer", |message| {
        assert!(!matches!(message.body, Body::Image(_)), "{message:?}");
        matches!(message.body, Body::Capability(_)).then_some(())
    });
    // Twice is once, and ends once.
    for status in [0, 0] {
        assert_eq!(ask(&mut client, "axial-local", start()), status);
    }
    rig.frame(&view, header(&rig, true), &pixels());
    client.wait_for("an image", |message| {
        matches!(message.body, Body::Image(_)).then_some(())
    });
    assert_eq!(ask(&mut client, "axial-local", stop), 0);
    assert_eq!(ask(&mut client, "axial-local", stop), 1);
}

/// At an image every ten seconds the one that the workflow hides stood for ten seconds more.
#[test]
fn the_cover_of_an_image_waits_for_no_pace() {
    let said = |message: &Message<'_>| {
        let is_image = matches!(message.body, Body::Image(_));
        is_image.then(|| {
            message
                .metadata
                .get("ImageStatus")
                .map(ToString::to_string)
                .unwrap_or_default()
        })
    };
    // On a busy machine an image may have grown old before it is looked at: then from the beginning.
    let live = || {
        let rig = Rig::of(VIEWS, |_| ());
        let view = rig.view("axial-local", pixels().len());
        let mut client = rig.client();
        assert_eq!(ask(&mut client, "axial-local", start()), 0);
        rig.frame(&view, header(&rig, true), &pixels());
        let is_live = client.wait_for("the image", said) == "LIVE";
        is_live.then_some((rig, view, client))
    };
    let (rig, _view, mut client) = (0..5).find_map(|_| live()).expect("an image that is live");
    rig.may(Workflow::BUMPED);
    // Two heart-beats a second come meanwhile.
    let mut beats = 0;
    let covered = loop {
        let message = client.next().unwrap();
        beats += u32::from(message.device == "Trocar");
        if let Some(status) = said(&message) {
            break status;
        }
        assert!(beats < 8, "no cover");
    };
    assert_eq!(covered, "COVERED: the marker on the patient was pushed");
}

#[test]
fn an_examination_that_is_said_not_to_be_the_patients_is_not_sent() {
    let rig = Rig::new();
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let grid = VolumeGrid::checked([4, 4, 4], Affine::from_rows(rows)).unwrap();
    let loader = rig.volume(&grid, |_| 0);
    loader.serve_late_joiners();
    let mut client = rig.client();
    let volume = Message::new(DeviceName::new("Volume").unwrap(), Body::Query(Query::Get(Kind::Image)));
    // `Ok`: it came; else why not.
    let mut asked = || {
        client.send(&volume);
        client.wait_for("the examination", |message| match &message.body {
            Body::Image(_) => Some(Ok(())),
            Body::Status(status) => {
                let words = String::from_utf8_lossy(&status.words).into_owned();
                words.starts_with("the examination is").then_some(Err(words))
            }
            _ => None,
        })
    };
    while asked().is_err() {}
    rig.may(Workflow::REJECTED);
    let words = loop {
        if let Err(words) = asked() {
            break words;
        }
    };
    assert_eq!(words, "the examination is said not to be the patient's");
}

/// Others have their poses while it does, and it is answered all that it asks.
#[test]
fn a_flood_of_questions_is_read_at_its_pace_and_each_is_answered() {
    const COUNT: usize = 2000;
    let rig = Rig::new();
    let mut flood = rig.client();
    let one = get(Kind::Capability, Version::One).to_vec().unwrap();
    let mut stream = flood.stream.try_clone().unwrap();
    let began_ns = rig.now_ns();
    std::thread::spawn(move || std::io::Write::write_all(&mut stream, &one.repeat(COUNT)));
    let mut answers = 0;
    while answers < COUNT {
        let message = flood.next().unwrap();
        answers += usize::from(matches!(message.body, Body::Capability(_)));
    }
    // 200 in 50 ms are read, and the rest waits: however fast the machine is, the last came in the tenth such tick.
    let took_ms = (rig.now_ns() - began_ns) / 1_000_000;
    assert!(took_ms >= 400, "{COUNT} answers in {took_ms} ms");
}
