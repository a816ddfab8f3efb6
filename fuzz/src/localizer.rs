//! What a localizer of NDI sends, and what one is sent.

use ndi::session::{Action, Client, ClientRules, Device, DeviceRules, Event};
use ndi::status::{MarkerStatus, ToolStatus};
use ndi::{
    Alert, Answer, Bx2, Bx2Frame, Bx2Marker, Bx2Markers, Bx2Tool, Command, Decoder, Frame, FrameKind, Handle, Limits,
    Markers, Polled, Reply, ReplyOption, Rom, Transform, UNIT_TOLERANCE, binary_reply, bx_body, bx2_body, crc,
    parse_bx, parse_bx2, parse_phinf, parse_phsr, parse_tx, text_reply, tx_text,
};

use crate::Failure;

/// Start sequence of a short reply, with which all seeds begin that are not text.
const SHORT: [u8; 2] = [0xC4, 0xA5];

/// The same bytes, with the CRCs of the short replies that are whole: else nearly all that is changed would end there.
pub(crate) fn mended(bytes: &[u8]) -> Vec<u8> {
    let mut mended = Vec::new();
    let mut rest = bytes;
    while !rest.is_empty() {
        let length = rest
            .get(2..4)
            .and_then(|two| two.first_chunk())
            .map(|two| u16::from_le_bytes(*two));
        let body = length.and_then(|length| rest.get(6..6 + usize::from(length)));
        let taken = match (rest.starts_with(&SHORT), body) {
            (true, Some(body)) => {
                mended.extend(binary_reply(body));
                body.len() + 8
            }
            _ => {
                let end = rest.iter().position(|byte| *byte == b'\r').unwrap_or(rest.len());
                let words = rest.get(..end.saturating_sub(4)).unwrap_or_default();
                mended.extend(words);
                mended.extend(format!("{:04X}\r", crc::crc16(words)).bytes());
                end + 1
            }
        };
        rest = rest.get(taken..).unwrap_or_default();
    }
    mended
}

/// As it is, and mended; in pieces of a length that the first byte tells. The next two are the options of TX and BX.
pub(crate) fn ndi(bytes: &[u8]) {
    let [piece, a, b, bytes @ ..] = bytes else {
        return;
    };
    let (piece, options) = (usize::from(*piece) + 1, ReplyOption(u16::from_le_bytes([*a, *b])));
    stream(bytes, piece, options);
    stream(&mended(bytes), piece, options);
    sessions(bytes, piece);
    sessions(&mended(bytes), piece);
    let _ = Rom::parse(bytes);
}

fn stream(bytes: &[u8], piece: usize, options: ReplyOption) {
    let mut decoder = Decoder::new(Limits::DEFAULT);
    for mut bytes in bytes.chunks(piece) {
        while let Some(result) = decoder.feed(&mut bytes) {
            match result {
                Ok(Reply::Text(text)) => text_read(text, options),
                Ok(Reply::Binary(body)) => body_read(body, options),
                Err(malformed) => drop((malformed.fields().json(), malformed.to_string(), malformed.advice())),
            }
        }
    }
    drop(decoder.end().map(|malformed| malformed.fields().json()));
}

fn text_read(text: &str, options: ReplyOption) {
    drop(Answer::of(text).fields().json());
    let _ = (parse_phsr(text), parse_phinf(text, options.0));
    if let Ok(polled) = parse_tx(text, options) {
        let again = parse_tx(&tx_text(&polled, options), options);
        same(&polled, again.ok().as_ref(), "TX");
        Frame::of_polled(&polled, UNIT_TOLERANCE).iter().for_each(judged);
    }
}

fn body_read(body: &[u8], options: ReplyOption) {
    if let Ok(polled) = parse_bx(body, options) {
        let again = parse_bx(&bx_body(&polled, options), options);
        same(&polled, again.ok().as_ref(), "BX");
        Frame::of_polled(&polled, UNIT_TOLERANCE).iter().for_each(judged);
    }
    if let Ok(reply) = parse_bx2(body) {
        let again = parse_bx2(&bx2_body(&reply)).map(|again| Bx2 {
            skipped: reply.skipped,
            ..again
        });
        // By their words, as a NaN is not equal to itself.
        let again = again.ok().map(|again| again.fields().json());
        assert_eq!(
            again,
            Some(reply.fields().json()),
            "what was read is not what is written of it"
        );
        Frame::of_bx2(&reply, UNIT_TOLERANCE).iter().for_each(judged);
    }
}

fn same(polled: &Polled, again: Option<&Polled>, reply: &str) {
    let again = again.map(|again| again.fields(reply).json());
    assert_eq!(
        again,
        Some(polled.fields(reply).json()),
        "what was read is not what is written of it"
    );
}

/// Whatever came, a pose turns by a rotation and lies where a localizer sees.
fn judged(frame: &Frame) {
    drop(frame.fields().json());
    for pose in frame.tools.iter().filter_map(|sight| sight.pose().ok()) {
        let norm = pose.q.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(
            (norm - 1.0).abs() <= UNIT_TOLERANCE,
            "a pose with a quaternion of length {norm}"
        );
        assert!(
            pose.t_mm.iter().all(|x| x.abs() <= ndi::MOST_MM),
            "a pose at {:?}",
            pose.t_mm
        );
    }
}

/// A client that is sent this from the start, and one that tracks when it comes; a device that is sent it.
fn sessions(bytes: &[u8], piece: usize) {
    let rules = ClientRules {
        markers: Markers::All,
        ..ClientRules::default()
    };
    let mut new = Client::new(rules.clone());
    let mut tracking = Client::new(rules);
    let mut device = Device::new(DeviceRules::default());
    let mut actions = tracking.step(Event::Connected, 0);
    while let Some(Action::Send(command)) = actions.iter().find(|action| matches!(action, Action::Send(_))) {
        let reply = device.bytes(command);
        if tracking.is_tracking() {
            break;
        }
        actions = tracking.step(Event::Bytes(&reply), 0);
    }
    new.step(Event::Connected, 0);
    for (piece, number) in bytes.chunks(piece).zip(1..) {
        let now = number * 100_000_000;
        for client in [&mut new, &mut tracking] {
            for action in [client.step(Event::Bytes(piece), now), client.step(Event::Tick, now)].concat() {
                if let Action::Publish(frame, _) = action {
                    judged(&frame);
                }
            }
        }
        drop(device.bytes(piece));
    }
}

/// Replies of each kind, a definition, and commands; before each the length of its pieces and the options.
pub(crate) fn ndi_seeds() -> Result<Vec<Vec<u8>>, Failure> {
    let options = ReplyOption(0x1801);
    let bx2 = bx2_body(&seen());
    let polled = parse_bx(&[1, 1, 2, 0x31, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0], options)?;
    let commands = [Command::Init, Command::Phsr(0), Command::Tstart, Command::Bx(options)];
    let replies = [
        text_reply("OKAY"),
        text_reply("ERROR0C"),
        text_reply("020103102031"),
        text_reply(&tx_text(&polled, options)),
        binary_reply(&bx_body(&polled, options)),
        binary_reply(&bx2),
    ];
    let all = [
        replies.concat(),
        commands.iter().flat_map(|command| command.to_bytes(true)).collect(),
    ];
    let head = [6, 0x01, 0x18];
    Ok(replies
        .iter()
        .chain(&all)
        .map(|bytes| [&head[..], bytes].concat())
        .collect())
}

/// A frame with a tool that is seen, one that is not, and two strays.
fn seen() -> Bx2 {
    let transform = Transform {
        q: [1.0, 0.0, 0.0, 0.0],
        t_mm: [1.0, -2.0, -1500.0],
        error_mm: 0.1,
    };
    let tool = |handle, status, transform| Bx2Tool {
        handle: Handle(handle),
        status: ToolStatus(status),
        transform,
    };
    let stray = |index, status| Bx2Marker {
        status: MarkerStatus(status),
        index,
        place_mm: [1.0, 2.0, -1400.0],
    };
    let frame = Bx2Frame {
        kind: FrameKind(2),
        index: 0,
        status: ToolStatus(0),
        number: 7,
        device_ns: 1_700_000_000_123_456_789,
        tools: vec![tool(1, 0, Some(transform)), tool(2, 0x010D, None)],
        markers: vec![Bx2Markers {
            handle: Handle::STRAY,
            markers: vec![stray(0, 0), stray(1, 6)],
        }],
        errors: vec![(Handle(1), vec![0.1, 0.2])],
    };
    Bx2 {
        frames: vec![frame],
        alerts: vec![Alert { kind: 2, code: 1 }],
        skipped: 0,
    }
}
