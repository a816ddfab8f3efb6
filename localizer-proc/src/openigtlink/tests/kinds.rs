//! Peers that send a tool in several kinds of message, and in several lists: which of them makes frames, and what the others are good for.

use igtl::{Orientation, Position, Tool};

use super::*;

const TURN: f32 = 0.37;

/// The turn that all poses here have, whose numbers a matrix and a quaternion round otherwise.
fn matrix(x: f32) -> Matrix {
    let (sin, cos) = TURN.sin_cos();
    let columns = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
    Matrix { columns, ..at(x) }
}

fn quaternion() -> [f32; 4] {
    let (sin, cos) = (0.5 * TURN).sin_cos();
    [0.0, 0.0, sin, cos]
}

fn bytes(device: &str, body: Body<'static>, at_ns: i64, words: &[(&str, &str)]) -> Vec<u8> {
    let mut message = Message::new(DeviceName::new(device).unwrap(), body).in_version(Version::Two);
    message.stamp = stamp(at_ns);
    for (key, word) in words {
        let (bytes, encoding) = (word.as_bytes().to_vec(), US_ASCII);
        message.metadata = message.metadata.with(key, Text { encoding, bytes });
    }
    message.to_vec().unwrap()
}

fn transform(name: &str, at_ns: i64, x: f32, word: &str) -> Vec<u8> {
    bytes(
        name,
        Body::Transform(matrix(x)),
        at_ns,
        &[(igtl::TRANSFORM_STATUS, word)],
    )
}

fn position(name: &str, at_ns: i64, x: f32, word: &str) -> Vec<u8> {
    let body = Body::Position(Position {
        place: [x, 0.0, -1500.0],
        orientation: Orientation::Full(quaternion()),
    });
    bytes(name, body, at_ns, &[(igtl::TRANSFORM_STATUS, word)])
}

/// A TDATA of this name with these tools, all with OK.
fn list(device: &str, at_ns: i64, tools: &[(&str, f32)]) -> Vec<u8> {
    let keys: Vec<String> = tools.iter().map(|(name, _)| format!("{name}Status")).collect();
    let words: Vec<(&str, &str)> = keys.iter().map(|key| (key.as_str(), "OK")).collect();
    let tool = |(name, x): &(&str, f32)| Tool {
        name: DeviceName::new(name).unwrap(),
        kind: ToolKind::Six,
        pose: matrix(*x),
    };
    bytes(device, Body::Tdata(tools.iter().map(tool).collect()), at_ns, &words)
}

const T: &str = "StylusToTracker";
const R: &str = "ReferenceToTracker";

/// What a client makes of messages, each with the time of its arrival.
#[derive(Default)]
struct Heard {
    frames: Vec<Frame>,
    told: Vec<String>,
    refused: usize,
}

impl Heard {
    fn hear(&mut self, client: &mut OpenIgtLink, bytes: &[u8], now_ns: i64) {
        let acts = [client.tick(now_ns), client.bytes(bytes, now_ns)].concat();
        self.refused += acts.iter().filter(|act| **act == Act::Refused).count();
        self.told.extend(words(&acts).into_iter().map(str::to_owned));
        self.frames.extend(super::frames(acts));
    }

    /// How many frames have poses of all these markers.
    fn whole(&self, markers: &[u32]) -> usize {
        let is_whole = |frame: &&Frame| {
            let has = |marker: &u32| seen(frame).iter().any(|(of, place)| of == marker && place.is_ok());
            markers.iter().all(has)
        };
        self.frames.iter().filter(is_whole).count()
    }
}

/// A device hung and its peer sent each measurement as TRANSFORM and POSITION: frames of two numbers in turn, and never FROZEN.
#[test]
fn one_kind_of_message_makes_the_frames_of_a_tool() {
    let mut client = client(StatusRule::Required);
    let mut heard = Heard::default();
    for k in 0..50 {
        for bytes in [
            transform(T, 50 * MS * k, 7.0, "OK"),
            position(T, 50 * MS * k, 7.0, "OK"),
        ] {
            heard.hear(&mut client, &bytes, 50 * MS * k);
        }
    }
    client.tick(5000 * MS);
    let first = heard.frames[0].seen[0];
    assert!(heard.frames.len() >= 49 && heard.frames.iter().all(|frame| frame.seen == [first]));
    assert_eq!((heard.told, heard.refused), (Vec::new(), 0));
    // What is not used has other numbers, or nothing would be shown here.
    let mut other = super::client(StatusRule::Required);
    other.bytes(&position(T, 0, 7.0, "OK"), 0);
    assert_ne!(frames(other.tick(50 * MS))[0].seen, [first]);
}

/// TRANSFORMs of tool and patient and POSITIONs of both, of one stamp: never a frame of both, and "stamps do not tell instants apart".
#[test]
fn tool_and_patient_in_two_kinds_of_message_under_one_stamp_are_one_frame() {
    let mut client = client(StatusRule::Required);
    let mut heard = Heard::default();
    for k in 0..50_i64 {
        let (at_ns, x) = (50 * MS * k, k as f32);
        for bytes in [transform(T, at_ns, x, "OK"), transform(R, at_ns, 5.0, "OK")] {
            heard.hear(&mut client, &bytes, at_ns);
        }
        for bytes in [position(T, at_ns, x, "OK"), position(R, at_ns, 5.0, "OK")] {
            heard.hear(&mut client, &bytes, at_ns);
        }
    }
    assert_eq!((heard.whole(&[0, 1]), heard.frames.len()), (50, 50));
    assert_eq!((heard.told, client.wrong()), (Vec::new(), String::new()));
}

/// Nor does a lost tool, in both kinds of message from the beginning, say anything of stamps.
#[test]
fn a_tool_that_two_kinds_of_message_lose_is_lost_once() {
    let mut client = client(StatusRule::Required);
    let mut heard = Heard::default();
    for k in 0..50_i64 {
        let at_ns = 50 * MS * k;
        for bytes in [transform(T, at_ns, 1.0, "MISSING"), position(T, at_ns, 1.0, "MISSING")] {
            heard.hear(&mut client, &bytes, at_ns);
        }
        heard.hear(&mut client, &transform(R, at_ns, 5.0, "OK"), at_ns);
    }
    assert_eq!((heard.whole(&[1]), heard.frames.len()), (50, 50));
    assert_eq!((heard.told, client.wrong()), (Vec::new(), String::new()));
}

/// Under stamps of its own the other kind is left out, counted and told once.
#[test]
fn a_kind_of_message_that_is_not_used_is_counted_and_told_once() {
    let mut client = client(StatusRule::Required);
    let mut heard = Heard::default();
    for k in 0..50 {
        heard.hear(&mut client, &transform(T, 50 * MS * k, 7.0, "OK"), 50 * MS * k);
        heard.hear(&mut client, &position(T, 50 * MS * k + MS, 7.0, "OK"), 50 * MS * k + MS);
    }
    assert_eq!(
        heard.told,
        ["StylusToTracker comes as TRANSFORM and as POSITION: POSITION is not used"]
    );
    // The last one might be ahead of its TRANSFORM.
    assert_eq!(heard.refused, 49);
}

/// Nothing that hangs is new for long by that: another kind takes over once no pose of the first can be shown any more.
#[test]
fn another_kind_of_message_takes_over_where_the_first_is_silent() {
    let mut client = client(StatusRule::Required);
    let mut heard = Heard::default();
    for k in 0..100 {
        let now_ns = 50 * MS * k;
        if k < 20 {
            heard.hear(&mut client, &transform(T, now_ns, 7.0, "OK"), now_ns);
        }
        heard.hear(&mut client, &position(T, now_ns, 7.0, "OK"), now_ns);
    }
    let late: Vec<i64> = heard
        .frames
        .iter()
        .map(|frame| frame.first_ns)
        .filter(|ns| *ns > 950 * MS)
        .collect();
    // The first silence that is longer than 2 s ends with the 60th.
    assert_eq!(late.first(), Some(&(3000 * MS)));
    assert!(late.len() >= 38, "{late:?}");
    let told = "StylusToTracker comes as POSITION and no longer as TRANSFORM: POSITION is used now";
    assert!(heard.told.iter().any(|words| words == told), "{:?}", heard.told);
}

/// A loss counts whichever kind says it, under stamps of its own too; a lost tool does not come back by a kind that is not used.
#[test]
fn a_lost_tool_is_lost_whichever_kind_of_message_says_so() {
    for is_first_lost in [true, false] {
        let mut client = client(StatusRule::Required);
        let mut heard = Heard::default();
        for k in 0..200 {
            let now_ns = 50 * MS * k;
            let words = if k < 10 { ["OK"; 2] } else { ["MISSING", "OK"] };
            let [first, second] = if is_first_lost { words } else { [words[1], words[0]] };
            heard.hear(&mut client, &transform(T, now_ns, k as f32, first), now_ns);
            heard.hear(&mut client, &position(T, now_ns + MS, k as f32, second), now_ns + MS);
        }
        let shown = heard
            .frames
            .iter()
            .flat_map(seen)
            .filter(|(_, place)| place.is_ok())
            .count();
        // Where the POSITION says it first, the TRANSFORM of that instant had gone before.
        assert!((9..=11).contains(&shown), "{is_first_lost} {shown}");
    }
}

/// The kind that is used fell silent, and another that loses the tool was heard once: nothing came, where the tool is not seen.
#[test]
fn a_tool_that_is_lost_goes_on_being_lost_where_the_kind_of_message_that_is_used_is_silent() {
    let mut client = client(StatusRule::Required);
    let mut heard = Heard::default();
    for k in 0..60 {
        let now_ns = 50 * MS * k;
        let bytes = match k < 10 {
            true => transform(T, now_ns, k as f32, "OK"),
            false => position(T, now_ns, k as f32, "MISSING"),
        };
        heard.hear(&mut client, &bytes, now_ns);
    }
    let losses: Vec<i64> = heard
        .frames
        .iter()
        .filter(|frame| frame.seen[0].outcome.is_err())
        .map(|frame| frame.first_ns)
        .collect();
    let longest_ns = losses.windows(2).map(|pair| pair[1] - pair[0]).max();
    assert!(
        losses[0] == 500 * MS && longest_ns <= Some(500 * MS) && losses.len() > 35,
        "{losses:?}"
    );
}

/// A peer's first messages were of the middle of an instant: the tool came as one kind, the patient as another, and never in one frame.
#[test]
fn the_kind_of_message_that_has_tool_and_patient_is_the_one_that_is_used() {
    let mut client = client(StatusRule::Required);
    let mut heard = Heard::default();
    for k in 0..50 {
        let now_ns = 50 * MS * k;
        heard.hear(&mut client, &transform(T, now_ns, k as f32, "OK"), now_ns);
        heard.hear(&mut client, &list("", now_ns, &[(T, k as f32), (R, 5.0)]), now_ns);
    }
    assert!(heard.whole(&[0, 1]) >= 48, "{}", heard.whole(&[0, 1]));
}

/// Tool and patient in one list and others in another, of one stamp: "seen and lost under one stamp" as long as both came.
#[test]
fn a_list_that_never_had_a_tool_does_not_lose_it() {
    let mut client = client(StatusRule::Required);
    let mut heard = Heard::default();
    for k in 0..50 {
        let now_ns = 50 * MS * k;
        heard.hear(
            &mut client,
            &list("Tracking", now_ns, &[(T, k as f32), (R, 5.0)]),
            now_ns,
        );
        heard.hear(&mut client, &list("Others", now_ns, &[("X", 1.0), ("Y", 2.0)]), now_ns);
    }
    assert_eq!((heard.whole(&[0, 1]), heard.frames.len()), (50, 50));
    // One that has had it does, and says so.
    let mut lost = Heard::default();
    for k in 50..100 {
        let now_ns = 50 * MS * k;
        lost.hear(&mut client, &list("Tracking", now_ns, &[(R, 5.0)]), now_ns);
        lost.hear(&mut client, &list("Others", now_ns, &[("X", 1.0), ("Y", 2.0)]), now_ns);
    }
    assert_eq!((lost.whole(&[1]), lost.whole(&[0]), lost.frames.len()), (50, 0, 50));
    // So does one of which nobody knows that it is of others.
    let mut unknown = super::client(StatusRule::Required);
    unknown.bytes(&transform(T, 0, 1.0, "OK"), 0);
    let acts = unknown.bytes(&list("", 0, &[("X", 1.0)]), MS);
    assert_eq!(seen(&frames(acts)[0]), [(0, Err(Lost::NotSeen))]);
    // And nothing is not silence: who sends empty lists says that nothing is seen.
    let mut empty = super::client(StatusRule::Required);
    let acts = empty.bytes(&list("Tracking", 0, &[]), 0);
    assert_eq!(frames(acts).len(), 1);
}

/// TRANSFORM said OK and TDATA MISSING. One TRANSFORM once more with other last bits, and LIVE and LOST came in turn for good.
#[test]
fn a_message_that_is_rounded_otherwise_does_not_bring_a_lost_tool_back() {
    let mut client = client(StatusRule::Required);
    let mut heard = Heard::default();
    for k in 0..200 {
        let now_ns = 50 * MS * k;
        heard.hear(&mut client, &transform(T, now_ns, 10.0, "OK"), now_ns);
        if k == 50 {
            heard.hear(&mut client, &transform(T, now_ns, 10.000_01, "OK"), now_ns);
        }
        let body = Body::Tdata(vec![Tool {
            name: DeviceName::new(T).unwrap(),
            kind: ToolKind::Six,
            pose: matrix(10.0),
        }]);
        let lost = bytes("", body, now_ns, &[("StylusToTrackerStatus", "MISSING")]);
        heard.hear(&mut client, &lost, now_ns + 25 * MS);
    }
    assert!(heard.whole(&[0]) <= 1, "{}", heard.whole(&[0]));
    assert_eq!(client.wrong(), "StylusToTracker is seen and lost under one stamp");
}
