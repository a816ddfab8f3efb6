//! Bytes of a peer into the drivers of localizer-proc, as a run has them: no pose that the peer does not vouch for.

use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::Duration;

use bus::message::MarkerFrame;
use geometry::Rigid;
use igtl::{Body, Decoder, Limits, Message, ToolStatus};
use localizer_proc::clocks::DeviceClock;
use localizer_proc::driver::Follows;
use localizer_proc::driver::{Act, Driver, Frame};
use localizer_proc::run;
use ndi::Rom;
use ndi::session::{Device, DeviceRules};
use scene::localizer::{
    ImagesSpec, LinkSpec, NdiSpec, OpenIgtLinkSpec, Peer, Reconnect, ShownBeams, StampRule, StatusRule,
};
use scene::tracking::PosedMarkers;

use crate::{Failure, links, localizer};

/// From one piece to the next.
const STEP_NS: i64 = 7_000_000;
/// What a driver puts a time later than its arrival by, at most, so that no two frames have one.
const AHEAD_NS: i64 = 1000;

fn markers(tool: Option<&str>, reference: Option<&str>) -> PosedMarkers {
    PosedMarkers {
        marker: tool.map(str::to_owned),
        marker_from_tool: Rigid::identity(),
        reference: reference.map(|name| (name.to_owned(), Rigid::identity())),
        noise: None,
    }
}

/// What holds of every frame: markers of the scene, each once, and a time that is not later than its arrival.
fn judged(frame: &Frame, driver: &dyn Driver, clock: &mut DeviceClock) {
    let known = driver.markers();
    for (at, seen) in frame.seen.iter().enumerate() {
        assert!(
            known.contains(&seen.marker),
            "marker {} is none of the scene",
            seen.marker
        );
        let again = frame.seen.iter().skip(at + 1).any(|other| other.marker == seen.marker);
        assert!(!again, "marker {} twice", seen.marker);
        if let Ok((pose, error_mm)) = seen.outcome {
            assert!(pose.translation_mm().iter().all(|mm| mm.abs() <= 1e5) && error_mm >= 0.0);
        }
    }
    let (captured, _) = clock.capture(frame);
    let late_ns = frame.arrival_ns - captured.at_ns;
    assert!(late_ns >= -AHEAD_NS, "captured {late_ns} ns before its arrival");
}

/// The first byte is the length of pieces, the next what the scene says.
pub(crate) fn igtl(bytes: &[u8]) {
    let [piece, says, bytes @ ..] = bytes else {
        return;
    };
    for bytes in [bytes.to_vec(), links::mended(bytes)] {
        followed(&bytes, usize::from(*piece) + 1, *says);
    }
}

fn followed(bytes: &[u8], piece: usize, says: u8) {
    let has = |bit: u8| says & (1 << bit) != 0;
    let spec = OpenIgtLinkSpec {
        peer: if has(0) { Peer::Plus } else { Peer::Auto },
        status: if has(1) {
            StatusRule::Required
        } else {
            StatusRule::AbsentMeansValid
        },
        stream: has(2).then_some(Duration::from_millis(20)),
        max_rotation_error: 2e-3,
        least_distance_mm: 10.0,
        reconnect: Reconnect::Always,
        silent: Duration::from_millis(1500),
        images: has(5).then(images),
    };
    let reference = has(4).then_some("Reference");
    let markers = markers(has(3).then_some("Stylus"), reference);
    let Ok(mut driver) = run::driver(&LinkSpec::OpenIgtLink(spec.clone()), Follows::Markers(&markers)) else {
        return;
    };
    let mut clock = DeviceClock::new(StampRule::Mapped, 0, 300_000_000);
    let (mut decoder, mut vouched) = (Decoder::new(Limits::POSES), Vec::new());
    driver.connected(0);
    for (number, piece) in (1..).zip(bytes.chunks(piece)) {
        let mut rest = piece;
        while let Some(message) = decoder.feed(&mut rest) {
            match message {
                Ok(message) => vouch(&message, spec.status, &mut vouched),
                // What is refused is refused for the driver too, which may leave then.
                Err(malformed) if malformed.recovery == igtl::Recovery::Close => break,
                Err(_) => {}
            }
        }
        let now_ns = number * STEP_NS;
        for act in [driver.bytes(piece, now_ns), driver.tick(now_ns)].concat() {
            match act {
                Act::Frame(frame) => {
                    judged(&frame, driver.as_ref(), &mut clock);
                    let seen = frame.seen.iter().filter(|seen| seen.outcome.is_ok());
                    for seen in seen {
                        let name = if seen.marker == MarkerFrame::REFERENCE {
                            reference
                        } else {
                            markers.marker.as_deref()
                        };
                        let is_it =
                            |(of, at): &(String, i64)| *at == frame.device_ns && name.is_none_or(|name| name == of);
                        assert!(
                            vouched.iter().any(is_it),
                            "nobody vouches for {seen:?} at {}",
                            frame.device_ns
                        );
                    }
                }
                Act::Image(picture) => {
                    let header = picture.header;
                    assert!(has(5), "an image that nobody asked for");
                    assert_eq!(header.width as usize * header.height as usize, picture.grey.len());
                    assert!(
                        header.shape().is_ok() && header.orientation().as_deref() == Some("MF"),
                        "{header:?}"
                    );
                    let captured = clock.capture_of_image(picture.device_ns, picture.arrival_ns).captured;
                    assert!(captured.at_ns <= picture.arrival_ns, "{captured:?}");
                }
                Act::Close(_) => return,
                Act::Send(_) | Act::Tell(_) | Act::Refused | Act::Emitters(..) => {}
            }
        }
    }
}

/// Images of 0.1 mm of a linear array, as a scene asks for them.
fn images() -> ImagesSpec {
    let beams = ShownBeams::Linear {
        from_mm: 0.0,
        to_mm: 3.0,
        face_mm: 0.0,
    };
    ImagesSpec {
        name: "Image".to_owned(),
        orientation: "MF".to_owned(),
        pixel_mm: Some([0.1; 2]),
        shown: Some((9.0, beams)),
        latest: std::time::Duration::from_millis(300),
    }
}

/// The tools whose poses this message may be used for, with its stamp.
fn vouch(message: &Message<'_>, rule: StatusRule, vouched: &mut Vec<(String, i64)>) {
    let is_good = |status: &ToolStatus| match rule {
        StatusRule::Required => *status == ToolStatus::Ok,
        StatusRule::AbsentMeansValid => matches!(status, ToolStatus::Ok | ToolStatus::Absent),
    };
    let at = i64::try_from(message.stamp.ns()).unwrap_or(0);
    let names: Vec<String> = match &message.body {
        Body::Transform(_) | Body::Position(_) | Body::Qtrans(_) => {
            let is_good = is_good(&ToolStatus::of_transform(&message.metadata));
            is_good.then(|| message.device.to_string()).into_iter().collect()
        }
        Body::Tdata(tools) => tools.iter().map(|tool| tool.name.to_string()).collect(),
        Body::Qtdata(tools) => tools.iter().map(|tool| tool.name.to_string()).collect(),
        _ => return,
    };
    let is_list = matches!(message.body, Body::Tdata(_) | Body::Qtdata(_));
    let of_list = |name: &String| !is_list || is_good(&ToolStatus::of_tool(&message.metadata, name));
    vouched.extend(names.into_iter().filter(of_list).map(|name| (name, at)));
}

/// Messages of two tools with a status each, one by one and as a list, and those of the parser's target.
pub(crate) fn igtl_seeds() -> Result<Vec<Vec<u8>>, Failure> {
    let mut seeds = links::igtl_seeds()?;
    let all = links::tools()?;
    seeds.push([&[255][..], &all].concat());
    seeds.push([&[20][..], &all].concat());
    let says = |says: u8| move |seed: &Vec<u8>| [&seed[..1], &[says], &seed[1..]].concat();
    Ok([0b11011, 0b11001, 0b00010]
        .into_iter()
        .flat_map(|bits| seeds.iter().map(says(bits)).collect::<Vec<_>>())
        .collect())
}

/// Replies to the polls of a client that tracks two tools; the first byte is the length of pieces.
pub(crate) fn ndi(bytes: &[u8]) {
    let [piece, bytes @ ..] = bytes else {
        return;
    };
    for bytes in [bytes.to_vec(), localizer::mended(bytes)] {
        polled(&bytes, usize::from(*piece) + 1);
    }
}

fn polled(bytes: &[u8], piece: usize) {
    let Some(rom) = definition() else { return };
    let tools = ["ball", "patient"].map(|name| (name.to_owned(), rom.clone())).into();
    let link = LinkSpec::Ndi(NdiSpec { tools, single: None });
    let followed = markers(Some("ball"), Some("patient"));
    let Ok(mut driver) = run::driver(&link, Follows::Markers(&followed)) else {
        return;
    };
    let mut clock = DeviceClock::new(StampRule::Mapped, 0, 300_000_000);
    let mut device = Device::new(DeviceRules::default());
    let mut acts = driver.connected(0);
    // Until it polls.
    while driver.due_ns().is_none() {
        let sent = acts.iter().find_map(|act| match act {
            Act::Send(command) => Some(device.bytes(command)),
            _ => None,
        });
        let Some(reply) = sent else { return };
        acts = driver.bytes(&reply, 0);
    }
    let mut come: Vec<u8> = Vec::new();
    for (number, piece) in (1..).zip(bytes.chunks(piece)) {
        come.extend(piece);
        let now_ns = number * STEP_NS;
        for act in [driver.bytes(piece, now_ns), driver.tick(now_ns)].concat() {
            match act {
                Act::Frame(frame) => {
                    judged(&frame, driver.as_ref(), &mut clock);
                    let poses = frame.seen.iter().filter_map(|seen| seen.outcome.ok());
                    for (pose, _) in poses {
                        assert!(is_vouched(&come, pose.translation_mm()), "nobody vouches for {pose:?}");
                    }
                }
                Act::Close(_) => return,
                Act::Send(_) | Act::Tell(_) | Act::Refused | Act::Emitters(..) | Act::Image(_) => {}
            }
        }
    }
}

/// Whether this place stands in what came, behind a status that has nothing against it. BX2: handle and status of 16 bits each, then the
/// quaternion and the place in single precision; BX: a handle and a state of 8 bits; TX: in hundredths of a millimetre.
fn is_vouched(come: &[u8], mm: [f64; 3]) -> bool {
    const TURN: usize = 16;
    let place: Vec<u8> = mm.iter().flat_map(|mm| (*mm as f32).to_le_bytes()).collect();
    let binary = come.windows(place.len()).enumerate().any(|(at, window)| {
        let before = at.checked_sub(TURN).and_then(|end| come.get(..end)).unwrap_or_default();
        let bx2 = before.last_chunk::<2>().map(|two| u16::from_le_bytes(*two));
        let bx = before.last();
        // Of the 16 bits the low byte is a code and the next bit says missing.
        same(window, &place) && (bx2.is_some_and(|status| status & 0x01FF == 0) || bx == Some(&1))
    });
    let text = || {
        let words: String = mm.iter().map(|mm| ndi_decimal(*mm)).collect();
        come.windows(words.len()).any(|window| window == words.as_bytes())
    };
    binary || text()
}

/// Zeros have two signs.
fn same(a: &[u8], b: &[u8]) -> bool {
    let number = |four: &[u8]| four.first_chunk().map(|four| f32::from_le_bytes(*four));
    a.chunks(4).zip(b.chunks(4)).all(|(a, b)| number(a) == number(b))
}

fn ndi_decimal(mm: f64) -> String {
    let hundredths = (mm * 100.0).round();
    let sign = if hundredths < 0.0 { '-' } else { '+' };
    format!("{sign}{:07}", hundredths.abs())
}

/// A definition in a file, as a scene names one.
fn definition() -> Option<PathBuf> {
    static FILE: OnceLock<Option<PathBuf>> = OnceLock::new();
    let made = || {
        let rom = Rom::simulated(
            "Trocar",
            "fuzz",
            &[[0.0; 3], [50.0, 0.0, 0.0], [0.0, 60.0, 0.0], [0.0, 0.0, 70.0]],
        )
        .ok()?;
        let path = std::env::temp_dir().join(format!("trocar-fuzz-{}.rom", std::process::id()));
        std::fs::write(&path, rom.bytes()).ok()?;
        Some(path)
    };
    FILE.get_or_init(made).clone()
}

/// Those of the parser's target, without the options.
pub(crate) fn ndi_seeds() -> Result<Vec<Vec<u8>>, Failure> {
    let seeds = localizer::ndi_seeds()?;
    let of = |seed: &Vec<u8>| [&[255][..], seed.get(3..).unwrap_or_default()].concat();
    Ok(seeds.iter().map(of).collect())
}
